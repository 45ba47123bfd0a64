"""How shapes are coloured."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.dynamics.facts.machine_facts import BodyGeometry
from kinolab.dynamics.language.shapes import Box, Capsule, Cylinder, Disk, Shape, Sphere
from kinolab.show.scene.models.paint import MARK, paint, painted_bodies
from kinolab.show.scene.models.surface_mesh import is_room, join, normals, weld

RED = (0.9, 0.1, 0.1)
SHAPES: list[tuple[Shape, float]] = [
    (Box(1.0, 2.0, 3.0), 6.0),
    (Sphere(0.5, (1.0, 2.0, 3.0)), np.pi / 6.0),
    (Cylinder(0.5, 2.0, "x"), np.pi / 2.0),
    (Capsule(0.5, 2.0, "y"), np.pi / 2.0 + np.pi / 6.0),
    (Disk(0.5, 0.1, "y", (0.0, 1.0, 0.0)), np.pi / 40.0),
]


def volume(mesh: object) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    return float(np.sum(a * np.cross(b, c)) / 6.0)


@pytest.mark.parametrize(("shape", "expected"), SHAPES)
def test_a_painted_shape_is_closed_and_has_its_volume(shape: Shape, expected: float) -> None:
    """Flat facets inside a round body miss up to 3 % of its volume."""
    mesh = paint(shape, RED)
    assert (mesh.sides[:, 0] != mesh.sides[:, 1]).all()
    assert volume(mesh) == pytest.approx(expected, rel=0.03)
    assert len(mesh.vertices) - len(mesh.ends) + len(mesh.faces) == 2  # Euler's polyhedra


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("kind", [Disk, Cylinder])
def test_no_turn_of_a_wheel_below_a_full_one_looks_like_none(kind: type, axis: str) -> None:
    """The marked sector is one of eight, on both caps and on the rim."""
    mesh = paint(kind(0.25, 0.05, axis), RED)
    k = "xyz".index(axis)
    marked = (mesh.colors == MARK).all(axis=1)
    normal = normals(mesh.vertices, mesh.faces)[:, k]
    for part in (normal > 0.9, normal < -0.9, abs(normal) < 0.1):
        assert marked[part].mean() == pytest.approx(1 / 8)
    centre = mesh.vertices[mesh.faces[marked]].mean(axis=(0, 1))
    assert np.linalg.norm(np.delete(centre, k)) > 0.1  # [m]; on one side of the axle


@pytest.mark.parametrize("radius", [0.7, 1.9, 2.1, 7.9, 8.1, 20.0])  # [pixel]
@pytest.mark.parametrize("kind", ["ball", "disk", "capsule"])
def test_what_is_small_in_a_picture_has_fewer_faces_and_looks_round(
    kind: str, radius: float
) -> None:
    """All edges lie within 0.4 pixels of the true surface, or 1.5 % of the radius."""
    pixel, r = 0.01, 0.01 * radius
    shapes: dict[str, Shape] = {
        "ball": Sphere(r), "disk": Disk(r, 0.5 * r, "z"), "capsule": Capsule(r, 1.0, "z"),
    }  # fmt: skip
    mesh, fine = paint(shapes[kind], RED, pixel), paint(shapes[kind], RED)
    assert len(mesh.faces) < len(fine.faces) if radius < 8.0 else len(mesh.faces) == len(fine.faces)
    points = mesh.vertices[mesh.ends[mesh.creases]] if kind == "disk" else mesh.vertices[mesh.ends]
    middles = points.mean(axis=1)
    if kind != "ball":
        middles[:, 2] = np.sign(middles[:, 2]) * np.clip(abs(middles[:, 2]) - 0.5, 0.0, None)
    if kind == "disk":  # its rims; the other edges are straight in truth
        middles = middles[np.linalg.norm(points[:, 0] - points[:, 1], axis=1) < 1.2 * r]
    gaps = r - np.linalg.norm(middles[:, :2] if kind == "disk" else middles, axis=1)
    assert gaps.max() < 0.4 * pixel if radius < 8.0 else gaps.max() < 0.015 * r


def test_a_ball_has_two_tones_of_equal_area() -> None:
    mesh = paint(Sphere(1.0), RED)
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    red = (mesh.colors == RED).all(axis=1)
    assert area[red].sum() == pytest.approx(area[~red].sum())


def test_bodies_differ_in_colour_unless_they_name_one() -> None:
    cube = (Box(1.0, 1.0, 1.0),)
    named = BodyGeometry("named", cube, color=RED)
    bodies = [BodyGeometry("a", cube), BodyGeometry("b", cube), named]
    meshes = [body.mesh() for body in painted_bodies(bodies)]
    assert tuple(meshes[0].colors[0]) != tuple(meshes[1].colors[0])
    assert tuple(meshes[2].colors[0]) == RED


def test_a_cube_has_twelve_creases_and_its_diagonals_stay_blank() -> None:
    mesh = paint(Box(1.0, 1.0, 1.0), RED)
    assert mesh.creases.sum() == 12
    assert len(mesh.ends) == 18


def test_welding_a_triangle_soup_finds_the_neighbours() -> None:
    cube = paint(Box(1.0, 1.0, 1.0), RED)
    soup = cube.vertices[cube.faces].reshape(-1, 3)
    welded = weld(soup, np.arange(36).reshape(-1, 3), RED)
    assert len(welded.vertices) == 8
    assert welded.creases.sum() == 12


def test_joined_meshes_keep_their_own_edges() -> None:
    cube = paint(Box(1.0, 1.0, 1.0), RED)
    pair = join([cube, cube])
    assert len(pair.ends) == 36
    assert pair.faces.max() == 15
    assert len(join([]).faces) == 0


def test_a_shell_that_looks_inward_is_a_room() -> None:
    cube = paint(Box(1.0, 1.0, 1.0), RED)
    assert not is_room(cube)
    assert is_room(weld(cube.vertices, cube.faces[:, ::-1], RED))
    assert not is_room(weld(cube.vertices, cube.faces[:5, ::-1], RED))  # open: no inside


def test_a_disc_that_whirls_is_drawn_as_the_blades_that_sweep_it() -> None:
    """Closed solids that reach as far as the disc and cover a small part of it."""
    disc = Disk(0.8, 0.02, at=(0.0, 0.0, 0.3))
    (body,) = painted_bodies([BodyGeometry("rotor", (disc,), color=RED, whirl=9.0)])
    rotor = body.mesh()
    assert (rotor.sides[:, 0] != rotor.sides[:, 1]).all()
    assert np.linalg.norm(rotor.vertices[:, :2], axis=1).max() == pytest.approx(0.8, rel=0.01)
    assert abs(rotor.vertices[:, 2] - 0.3).max() < 0.02  # [m]
    assert 0.0 < volume(rotor) < 0.15 * np.pi * 0.8**2 * 0.02
