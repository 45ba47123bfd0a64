"""Shading and shadows."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.dynamics.language.shapes import Box
from kinolab.show.film.raster.light import (
    LIGHT_SAMPLES,
    light_samples,
    main_light,
    shade,
    shadow_points,
)
from kinolab.show.film.raster.rasterizer import GROUND, blank, darken
from kinolab.show.film.raster.shading import pen
from kinolab.show.scene.camera import frame_scene
from kinolab.show.scene.models.surface_mesh import weld
from kinolab.world.shapes.geometry import triangles

UP = np.array([0.0, 0.0, 1.0])


def test_a_shadow_lies_where_the_ray_meets_the_ground() -> None:
    """Light from 45 degrees above -x throws the shadow as far toward +x as the point is high."""
    toward = np.array([-1.0, 0.0, 1.0]) / np.sqrt(2.0)
    assert shadow_points(np.array([[2.0, 3.0, 1.5]]), toward)[0] == pytest.approx([3.5, 3.0, 0.0])


def test_a_point_on_the_ground_is_its_own_shadow() -> None:
    """That is what makes a wheel stand rather than float."""
    points = np.array([[2.0, 3.0, 0.0]])
    for lamp in light_samples(np.array([0.3, -0.2, 0.9])):
        assert shadow_points(points, lamp) == pytest.approx(points)


def test_every_lamp_is_above_the_horizon_in_every_view() -> None:
    points = np.random.default_rng(0).uniform(-1, 1, (20, 3))
    for view in ("perspective", "top", "front", "side"):
        found = light_samples(main_light(frame_scene(points, UP, view), UP))
        assert found.shape == (LIGHT_SAMPLES, 3)
        assert (found[:, 2] > 0.5).all()


def test_a_face_is_brightest_toward_the_light_and_never_black() -> None:
    grey = np.full((3, 3), 0.5)
    normals = np.array([[0.0, 0, 1], [1, 0, 0], [0, 0, -1]])
    toward, beside, away = shade(grey, normals, UP)[:, 0].astype(int)
    assert toward > beside
    assert beside == away > 50  # of 255; ambient light


@pytest.mark.parametrize("turn", [0.0, 0.4, 1.1])
def test_faces_that_look_at_a_lamp_cast_the_whole_shadow(turn: float) -> None:
    """A closed body's other faces lie in the shadow of these, so leaving them out shows nowhere."""
    size = (120, 90)
    corners = [[-1.0, -1.0, 0.0], [1.0, 1.0, 1.5]]
    tool = pen(frame_scene(corners, size=size), size, UP, 1)
    c, s = np.cos(turn), np.sin(turn)
    tilted = [[1, 0, 0, 0.1], [0, c, -s, 0.0], [0, s, c, 0.9]]
    body = weld(*triangles(Box(0.8, 0.5, 0.6)), (1.0, 0.0, 0.0)).moved(np.ravel(tilted))
    for k, lamp in enumerate(light_samples(tool.light)):
        shadows = [tool.shadows(body)[k], tool.at(shadow_points(body.vertices, lamp))[body.faces]]
        assert len(shadows[0]) < len(shadows[1])
        pictures = []
        for cast in shadows:
            canvas = blank(size, (200, 200, 200))
            canvas.kind[:] = GROUND
            darken(canvas, [cast], np.full(3, 0.5))
            pictures.append(canvas.color)
        assert (pictures[0] == pictures[1]).all()
        assert (pictures[0] == 100).any()


def test_an_open_surface_casts_the_shadow_of_both_its_sides() -> None:
    size = (60, 60)
    tool = pen(frame_scene([[-1, -1, 0], [1, 1, 1]], size=size), size, UP, 1)
    sheet = [[0.0, 0.0, 0.5], [1.0, 0.0, 0.5], [0.0, 1.0, 0.5]]
    for faces in ([[0, 1, 2]], [[0, 2, 1]]):
        assert all(len(cast) == 1 for cast in tool.shadows(weld(sheet, faces, (1.0, 0.0, 0.0))))
