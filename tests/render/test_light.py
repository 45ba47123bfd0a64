"""Shading and shadows."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.render.camera import frame_scene
from kinolab.render.light import LAMPS, lamps, main_light, shade, shadow_points

UP = np.array([0.0, 0.0, 1.0])


def test_a_shadow_lies_where_the_ray_meets_the_ground() -> None:
    """Light from 45 degrees above -x throws the shadow as far toward +x as the point is high."""
    toward = np.array([-1.0, 0.0, 1.0]) / np.sqrt(2.0)
    assert shadow_points(np.array([[2.0, 3.0, 1.5]]), toward)[0] == pytest.approx([3.5, 3.0, 0.0])


def test_a_point_on_the_ground_is_its_own_shadow() -> None:
    """That is what makes a wheel stand rather than float."""
    points = np.array([[2.0, 3.0, 0.0]])
    for lamp in lamps(np.array([0.3, -0.2, 0.9])):
        assert shadow_points(points, lamp) == pytest.approx(points)


def test_every_lamp_is_above_the_horizon_in_every_view() -> None:
    points = np.random.default_rng(0).uniform(-1, 1, (20, 3))
    for view in ("perspective", "top", "front", "side"):
        found = lamps(main_light(frame_scene(points, UP, view), UP))
        assert found.shape == (LAMPS, 3)
        assert (found[:, 2] > 0.5).all()


def test_a_face_is_brightest_toward_the_light_and_never_black() -> None:
    grey = np.full((3, 3), 0.5)
    normals = np.array([[0.0, 0, 1], [1, 0, 0], [0, 0, -1]])
    toward, beside, away = shade(grey, normals, UP)[:, 0].astype(int)
    assert toward > beside
    assert beside == away > 50  # of 255; ambient light
