from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from kinolab.dynamics.language.shapes import Box, Capsule, Cylinder, Disk, Shape, Sphere
from kinolab.world import lowest_z, triangles
from kinolab.world.shapes.geometry import half_extents
from kinolab.world.shapes.shape_surfaces import box_surface, cylinder_surface

AT = (0.3, -0.2, 0.1)
SHAPES: list[Shape] = [
    Box(0.6, 0.4, 0.2, at=AT),
    Sphere(0.3, at=AT),
    *(Cylinder(0.2, 0.5, axis=axis, at=AT) for axis in ("x", "y", "z")),
    *(Capsule(0.15, 0.5, axis=axis, at=AT) for axis in ("x", "y", "z")),
    *(Disk(0.25, 0.05, axis=axis, at=AT) for axis in ("x", "y", "z")),
]
VOLUMES = [
    0.6 * 0.4 * 0.2,
    4 / 3 * math.pi * 0.3**3,
    *3 * [math.pi * 0.2**2 * 0.5],
    *3 * [math.pi * 0.15**2 * 0.5 + 4 / 3 * math.pi * 0.15**3],
    *3 * [math.pi * 0.25**2 * 0.05],
]
SAGITTA = 5e-3  # [m]; the largest circle, radius 0.3 m, is drawn with corners at most 0.3 rad apart


def random_pose(rng: np.random.Generator) -> NDArray[np.float64]:
    turn = trimesh.transformations.random_rotation_matrix(rng.random(3))[:3, :3]
    return np.column_stack([turn, rng.uniform(-1, 1, 3)])


@pytest.mark.parametrize(("shape", "volume"), list(zip(SHAPES, VOLUMES, strict=True)))
def test_triangles_enclose_the_volume_of_the_shape(shape: Shape, volume: float) -> None:
    mesh = trimesh.Trimesh(*triangles(shape), process=False)
    assert mesh.is_watertight
    assert 0.97 * volume < mesh.volume <= volume * (1 + 1e-9)  # corners lie on the surface
    np.testing.assert_allclose(mesh.bounds.mean(axis=0), AT, atol=1e-6)  # [m]


@pytest.mark.parametrize("size", [1e-9, 1e-300])
@pytest.mark.parametrize("slender", [Capsule(1.0, 1.0), Capsule(1.0, 1e3), Sphere(1.0)])
def test_tiny_shapes_have_all_of_their_triangles(size: float, slender: Shape) -> None:
    lengths = {k: size * v for k, v in vars(slender).items() if k in ("radius", "length")}
    tiny, faces = triangles(replace(slender, **lengths))
    usual, same = triangles(slender)
    np.testing.assert_array_equal(faces, same)
    np.testing.assert_allclose(tiny / size, usual, rtol=1e-12, atol=1e-12)


def test_boxes_and_cylinders_are_triangulated_as_trimesh_does() -> None:
    half = np.array([0.3, 0.2, 0.1])
    box = trimesh.creation.box(2 * half)
    cylinder = trimesh.creation.cylinder(0.25, 0.05, sections=16)
    for theirs, ours in [(box, box_surface(half)), (cylinder, cylinder_surface(0.25, 0.025, 16))]:
        assert np.array_equal(ours[0], theirs.vertices)
        assert np.array_equal(ours[1], theirs.faces)


@pytest.mark.parametrize("shape", SHAPES)
def test_farthest_points_lie_on_the_surface_as_far_out_as_compiled_code_says(shape: Shape) -> None:
    n = np.random.default_rng(2).normal(size=(200, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    points = shape.support(n)
    np.testing.assert_allclose(np.einsum("ij,ij->i", n, points), half_extents(shape, n), rtol=1e-14)
    np.testing.assert_allclose(shape.depths(points), 0.0, atol=1e-15)
    assert (shape.depths(0.9 * points) > 0.0).all()
    assert (shape.depths(1.1 * points) < 0.0).all()


@pytest.mark.parametrize("shape", SHAPES)
def test_lowest_z_lies_just_below_the_triangles(shape: Shape) -> None:
    rng = np.random.default_rng(1)
    for _ in range(50):
        pose = random_pose(rng)
        lowest_corner = (triangles(shape)[0] @ pose[2, :3] + pose[2, 3]).min()
        assert lowest_corner - SAGITTA < lowest_z(shape, pose) <= lowest_corner + 1e-7  # [m]


def test_lowest_z_of_a_tilted_coin_is_exact() -> None:
    """A disk with its axis along y, rolled by a about x, reaches R cos a + h sin a downwards."""
    for a in np.linspace(-1.5, 1.5, 7):
        c, s = math.cos(a), math.sin(a)
        pose = np.array([[1, 0, 0, 5], [0, c, -s, 7], [0, s, c, 2.0]])
        expected = 2.0 - 0.25 * c - 0.025 * abs(s)
        assert lowest_z(Disk(0.25, 0.05, axis="y"), pose) == pytest.approx(expected, abs=1e-15)
