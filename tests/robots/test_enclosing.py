"""Solids around meshes contain every point, and hardly more than needed."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.dynamics.language.shapes import Box, Capsule
from kinolab.numerics.arrays import Array
from kinolab.robots.solids.enclosing import enclosing_shape
from kinolab.robots.tree.kinematic_tree import PlacedShape


def outside(solid: PlacedShape, points: Array) -> float:
    """Return by how much the farthest of points (n, 3) is outside a solid."""
    own = (points - solid.pose[:3, 3]) @ solid.pose[:3, :3]
    if isinstance(solid.shape, Box):
        half = 0.5 * np.array([solid.shape.x, solid.shape.y, solid.shape.z], dtype=float)
        return float((np.abs(own) - half).max())
    assert isinstance(solid.shape, Capsule)
    half_length = 0.5 * float(solid.shape.length)
    own[:, 2] -= np.clip(own[:, 2], -half_length, half_length)
    return float(np.linalg.norm(own, axis=1).max()) - float(solid.shape.radius)


def turned(points: Array, generator: np.random.Generator) -> Array:
    """Return points (n, 3) turned and moved at random."""
    turn = np.linalg.qr(generator.normal(size=(3, 3)))[0]
    return points @ turn.T + generator.normal(size=3)


@pytest.mark.parametrize("seed", range(40))
def test_every_point_is_inside(seed: int) -> None:
    generator = np.random.default_rng(seed)
    sizes = generator.uniform(0.0, 1.0, 3) ** 2
    points = turned(generator.uniform(-1.0, 1.0, (200, 3)) * sizes, generator)
    assert outside(enclosing_shape(points), points) < 1e-12


def test_a_rod_gets_a_capsule_and_a_brick_a_box() -> None:
    generator = np.random.default_rng(3)
    angles, along = generator.uniform(0, 2 * np.pi, 4000), generator.uniform(-1, 1, 4000)
    rod = np.column_stack([0.1 * np.cos(angles), 0.1 * np.sin(angles), along])
    solid = enclosing_shape(turned(rod, generator))
    assert isinstance(solid.shape, Capsule)
    assert abs(float(solid.shape.radius) - 0.1) < 0.01
    brick = np.array([[x, y, z] for x in (0, 2) for y in (0, 1) for z in (0, 0.5)], dtype=float)
    shape = enclosing_shape(brick).shape
    assert isinstance(shape, Box)
    assert sorted(map(float, (shape.x, shape.y, shape.z))) == pytest.approx([0.5, 1.0, 2.0])


def test_flat_meshes_have_some_thickness() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    assert outside(enclosing_shape(points), points) < 1e-12
