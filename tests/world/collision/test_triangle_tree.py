"""Searches of the tree of triangles, beside closest points that trimesh finds one by one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
import trimesh

from kinolab.numerics.arrays import Array, allocate
from kinolab.numerics.jit import kernel
from kinolab.numerics.struct import Record
from kinolab.world.distances.gjk import Convex
from kinolab.world.distances.triangle_gaps import mesh_clearance
from kinolab.world.distances.triangle_tree import (
    LANES,
    NOWHERE,
    Traversal,
    triangle_tree,
)
from kinolab.world.shapes.support_functions import SPHERE

COUNTS = (1, 2, LANES, LANES + 1, LANES**2, LANES**2 + 1, 5000)


class Scratch(NamedTuple):
    traversal: Traversal
    corners: Array
    simplex: Array


def random_triangles(count: int, rng: np.random.Generator, origin: float) -> Array:
    """Small triangles in a cube of 10 m, shape (count, 9)."""
    at = rng.uniform(-5.0, 5.0, (count, 1, 3)) + origin
    return np.ascontiguousarray((at + rng.normal(0.0, 0.2, (count, 3, 3))).reshape(count, 9))


def distances(triangles: Array, point: Array) -> Array:
    """Distance of a point (3,) to each triangle."""
    many = np.tile(point, (len(triangles), 1))
    nearest = trimesh.triangles.closest_point(triangles.reshape(-1, 3, 3), many)
    return np.asarray(np.linalg.norm(nearest - point, axis=1))


class Sphere:
    """A sphere beside triangles."""

    def __init__(self, triangles: Array, radius: float) -> None:
        self.tree = triangle_tree(triangles)
        self.radius, self._record = radius, Record(self.tree)

    def gap(self, at: Array, least: float, within: float) -> float:
        half, box = np.full(3, self.radius), np.concatenate([at - self.radius, at + self.radius])
        scratch = Record(Scratch(allocate(Traversal, {}), np.zeros((3, 3)), np.zeros((9, 3))))
        return float(ask(half, np.eye(3), at, box, least, within, self._record, scratch))


@kernel
def ask(half, turn, at, box, least, within, tree, scratch):  # type: ignore[no-untyped-def]
    shape = Convex(np.int64(SPHERE), half, turn, at)
    return mesh_clearance(shape, box, least, within, tree, scratch)


@pytest.mark.parametrize("origin", [0.0, 1e4])
@pytest.mark.parametrize("count", COUNTS)
def test_the_nearest_triangle_is_found(count: int, origin: float) -> None:
    rng = np.random.default_rng(count)
    triangles = random_triangles(count, rng, origin)
    sphere = Sphere(triangles, 0.1)
    for _ in range(20):
        at = rng.uniform(-7.0, 7.0, 3) + origin
        true = max(distances(triangles, at).min() - 0.1, 0.0)
        assert sphere.gap(at, 0.0, np.inf) == pytest.approx(true, abs=1e-8)
        assert sphere.gap(at, 0.0, true + 0.01) == pytest.approx(true, abs=1e-8)
        assert sphere.gap(at, 0.0, 0.5 * true) == 0.5 * true
        if true > 0.1:
            assert sphere.gap(at, true + 0.1, np.inf) < true + 0.1


@pytest.mark.parametrize("count", COUNTS)
def test_every_triangle_is_in_a_leaf_and_every_leaf_in_its_boxes(count: int) -> None:
    triangles = random_triangles(count, np.random.default_rng(1), 3.0)
    tree = triangle_tree(triangles)
    assert {*map(tuple, tree.triangles)} == {*map(tuple, triangles)}
    assert len(tree.triangles) - count < LANES
    leaves = len(tree.leaf_boxes)
    for layer, first in enumerate(tree.first):
        size = LANES ** (layer + 1)  # triangles below a box
        for box in range(-(-leaves // LANES**layer)):
            group, lane = first + box // LANES, box % LANES
            low, high = tree.boxes[group, :, :, lane] + tree.origin
            inside = tree.triangles[box * size : (box + 1) * size].reshape(-1, 3)
            np.testing.assert_allclose(inside.min(axis=0), low, atol=1e-5)
            np.testing.assert_allclose(inside.max(axis=0), high, atol=1e-5)
    filled = tree.boxes[:, 0, 0] < NOWHERE
    assert filled.sum() == sum(-(-leaves // LANES**k) for k in range(len(tree.first)))


def test_searches_of_meshes_look_at_few_triangles() -> None:
    """The sorted order is what makes boxes small: most leaves are far smaller than the whole."""
    tree = triangle_tree(random_triangles(5000, np.random.default_rng(2), 0.0))
    sides = tree.leaf_boxes[:, 3:] - tree.leaf_boxes[:, :3]
    assert np.median(sides.max(axis=1)) < 4.0  # of 10 m: 313 leaves, 6.8 along each side


@pytest.mark.parametrize("length", [1.0, 6.0, 100.0, 1e4])
def test_triangles_that_are_lines_but_for_rounding_are_met(length: float) -> None:
    """Such as the wires of a drawing, turned: the cross product of their edges is rounding."""
    rng = np.random.default_rng(7)
    for _ in range(60):
        along = rng.normal(size=3)
        along *= length / np.linalg.norm(along)
        begin = rng.uniform(-1.0, 1.0, 3)
        line = np.stack([begin, begin + along, begin + rng.uniform() * along])
        sphere = Sphere(np.ascontiguousarray(line[rng.permutation(3)].reshape(1, 9)), 0.1)
        aside = np.cross(along, rng.normal(size=3))
        aside /= np.linalg.norm(aside)
        gap = rng.uniform(0.0, 0.5)
        at = begin + rng.uniform() * along + (0.1 + gap) * aside
        assert sphere.gap(at, 0.0, 0.01) <= min(gap, 0.01) + 1e-9 * length
        assert sphere.gap(at, 0.0, np.inf) == pytest.approx(gap, abs=1e-9 * length)
        assert sphere.gap(begin + 0.5 * along, 0.0, 0.01) == 0.0
