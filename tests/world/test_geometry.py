from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from kinolab.dynamics.shapes import Box, Capsule, Cylinder, Disk, Shape, Sphere
from kinolab.world import lowest_z, reach, triangles

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


@pytest.mark.parametrize("shape", SHAPES)
def test_reach_bounds_every_corner_and_its_speed(shape: Shape) -> None:
    """Corners of a shape that spins about its own axis count without their spin."""
    rng = np.random.default_rng(2)
    bound = reach(shape)
    offset = triangles(shape)[0] - bound.center
    assert np.linalg.norm(offset, axis=1).max() <= bound.radius + 1e-7  # [m]
    assert np.linalg.norm(offset, axis=1).max() > bound.radius - SAGITTA
    for _ in range(20):
        v, w = rng.normal(size=(2, 3))
        if isinstance(shape, Sphere):
            w = np.zeros(3)
        elif bound.axis is not None:
            w = w - bound.axis * (bound.axis @ w)
        speed = np.linalg.norm(v + np.cross(w, offset), axis=1).max()
        limit = np.linalg.norm(v) + bound.lever * np.linalg.norm(w)
        assert speed <= limit + 1e-6  # [m/s]; capsules are drawn to 1e-7 m


def test_spin_about_its_own_axis_is_no_motion_of_a_disk() -> None:
    assert reach(Disk(0.25, 0.05, axis="y")).axis == pytest.approx([0, 1, 0])
    assert reach(Sphere(1.0)).lever == 0.0
    assert reach(Box(1, 1, 1)).axis is None
