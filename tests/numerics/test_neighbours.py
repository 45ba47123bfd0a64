"""Nearest neighbours against a look at all points."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.numerics.neighbours.insertion import add
from kinolab.numerics.neighbours.packing import pack
from kinolab.numerics.neighbours.queries import cheapest_within, nearest
from kinolab.numerics.neighbours.r_tree import (
    FILL,
    GROUPS,
    HEIGHT,
    LAYERS,
    LEAF_SIZE,
    LEAVES,
    MIN_CHILDREN,
    POINTS,
    ROOT,
    SPARE_LEAVES,
    RTree,
    clear,
    r_tree,
)
from kinolab.numerics.neighbours.selection import partition_median
from kinolab.numerics.simd import LANES
from kinolab.numerics.struct import Record

Array = np.ndarray

EXACT = np.float32(1.0)
ROUNDING = 1e-5  # relative, of squares in single precision
COUNTS = [1, 2, LEAF_SIZE - 1, LEAF_SIZE, LEAF_SIZE + 1, 2 * LEAF_SIZE, 100, 1000, 5000]


def square(points: Array, query: Array, period: Array) -> Array:
    apart = np.abs(points - query)
    with np.errstate(invalid="ignore"):
        other = np.where(np.isfinite(period), np.abs(period - apart), np.inf)
    return (np.minimum(apart, other) ** 2).sum(axis=1)


def periods(dimensions: int, periodic: bool) -> Array:
    return np.where((np.arange(dimensions) % 2 == 1) & periodic, 2.0, np.inf)


def planted(points: Array, period: Array) -> Record:
    found = Record(r_tree(len(points), period))
    for point in points:
        add(found, point)
    return found


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("dimensions", [1, 2, 6, 12, 28])
@pytest.mark.parametrize("periodic", [False, True])
def test_no_point_is_nearer_by_more_than_the_slack(
    count: int, dimensions: int, periodic: bool
) -> None:
    random, period = np.random.default_rng(count), periods(dimensions, periodic)
    points = random.uniform(-1, 1, (count, dimensions))
    tree = planted(points, period)
    for query in random.uniform(-1, 1, (50, dimensions)):
        squares = square(points, query, period)
        name, found = nearest(tree, query, -1, np.inf)
        assert squares[name] <= 1.1**2 * squares.min() * (1 + ROUNDING) + 1e-10
        assert found == pytest.approx(squares[name], rel=1e-4, abs=1e-10)
        name, found = nearest(tree, query, -1, np.inf, EXACT)
        assert squares[name] <= squares.min() * (1 + ROUNDING) + 1e-10


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("dimensions", [1, 6, 12, 28])
@pytest.mark.parametrize("periodic", [False, True])
def test_the_cheapest_within_a_radius_is_found(count: int, dimensions: int, periodic: bool) -> None:
    random, period = np.random.default_rng(count), periods(dimensions, periodic)
    points, costs = random.uniform(-1, 1, (count, dimensions)), random.permutation(count)
    tree = planted(points, period)
    for query in random.uniform(-1, 1, (50, dimensions)):
        squares = square(points, query, period)
        within = np.quantile(squares, 0.01)
        around = np.flatnonzero(squares <= within)
        if np.abs(squares / within - 1.0).min() > ROUNDING:  # no point is on the border
            assert cheapest_within(tree, costs, query, within) == around[costs[around].argmin()]
        assert cheapest_within(tree, costs, query, 0.9 * squares.min()) == -1


@pytest.mark.parametrize("period", [np.inf, 2.0])
def test_it_finds_the_same_after_a_real_tree_has_grown_outwards(period: float) -> None:
    """Points of a random walk, later ones farther out, more than one packing."""
    random, periods = np.random.default_rng(1), np.array([np.inf, period, np.inf, np.inf])
    points = np.cumsum(random.normal(size=(40_000, 4)), axis=0) * 0.1
    points[:, 1] = (points[:, 1] + 1.0) % 2.0 - 1.0
    tree = planted(points, periods)
    for query in points[random.integers(0, len(points), 100)] + random.normal(size=(100, 4)):
        query[1] = (query[1] + 1.0) % 2.0 - 1.0
        squares = square(points, query, periods)
        name, _ = nearest(tree, query, -1, np.inf)
        assert squares[name] <= 1.1**2 * squares.min() * (1 + ROUNDING) + 1e-10


def leaves_below(tree: RTree, at: int, layer: int) -> list[int]:
    """Return the leaves below a group; boxes on the way hold all points, no group is a dwarf."""
    if layer == 0:
        return [at]
    found: list[int] = []
    for lane in range(tree.branches[at]):
        leaves = leaves_below(tree, int(tree.children[at, lane]), layer - 1)
        names = [n for k in leaves for n in tree.names[k * LEAF_SIZE :][: tree.sizes[k]]]
        assert (tree.boxes[at, 0, :, lane] == tree.points[names].min(axis=0)).all()
        assert (tree.boxes[at, 1, :, lane] == tree.points[names].max(axis=0)).all()
        found += leaves
    return found


def orders() -> dict[str, Array]:
    random = np.random.default_rng(2)
    points = random.uniform(-1, 1, (9000, 3))
    return {
        "random": points,
        "along an axis": points[np.argsort(points[:, 0])],
        "from inside": points[np.argsort((points**2).sum(axis=1))],
        "few places": np.round(2 * points),
        "one place": np.zeros((9000, 3)),
    }


@pytest.mark.parametrize("order", orders())
@pytest.mark.parametrize("count", [33, 64, 65, 200, 511, 512, 700, 4095, 4096, 8191, 9000])
def test_boxes_hold_their_points_and_memory_is_enough_in_any_order(order: str, count: int) -> None:
    tree = r_tree(count, np.full(3, np.inf))
    record, points = Record(tree), orders()[order][:count]
    for point in points:
        add(record, point)
    leaves = leaves_below(tree, int(tree.counts[ROOT]), int(tree.counts[HEIGHT]))
    assert sorted(leaves) == list(range(tree.counts[LEAVES]))
    assert (tree.sizes[leaves] >= LEAF_SIZE // 2).all()
    names = np.concatenate([tree.names[k * LEAF_SIZE :][: tree.sizes[k]] for k in leaves])
    assert sorted(names) == list(range(count))
    assert tree.counts[LEAVES] <= len(tree.sizes)
    assert tree.counts[GROUPS] <= len(tree.branches)
    assert tree.counts[HEIGHT] <= LAYERS


def test_packing_makes_full_leaves_and_no_dwarfs_of_any_number_of_points() -> None:
    tree = r_tree(20_000, np.full(2, np.inf))
    record = Record(tree)
    tree.points[:] = np.random.default_rng(0).uniform(-1, 1, (20_000, 2))
    for count in [*range(2 * LEAF_SIZE, 3000), *range(3000, 20_000, 997)]:
        tree.counts[POINTS] = count
        pack(record)
        leaves, groups = int(tree.counts[LEAVES]), int(tree.counts[GROUPS])
        assert leaves <= count // FILL + SPARE_LEAVES // 2
        sizes, branches = tree.sizes[:leaves], tree.branches[:groups]
        assert sizes.sum() == count
        assert LEAF_SIZE // 2 <= sizes.min() <= sizes.max() < LEAF_SIZE
        assert groups == 1 or branches[1:].min() >= MIN_CHILDREN
        assert branches.max() < LANES


def test_every_point_finds_itself_at_any_time() -> None:
    random, period = np.random.default_rng(0), np.array([np.inf, 2.0, np.inf])
    points = random.normal(size=(700, 3)) * [1.0, 0.3, 5.0]
    trees = Record(r_tree(700, period))
    for name, point in enumerate(points):
        add(trees, point)
        asked = int(random.integers(name + 1))
        assert nearest(trees, points[asked], -1, np.inf)[0] == asked


def test_a_cleared_tree_is_as_good_as_new() -> None:
    random, period = np.random.default_rng(0), np.full(2, np.inf)
    tree = planted(random.normal(size=(700, 2)), period)
    clear(tree)
    assert nearest(tree, np.zeros(2), 77, np.inf)[0] == 77
    points = random.normal(size=(100, 2))
    for point in points:
        add(tree, point)
    assert [nearest(tree, point, -1, np.inf)[0] for point in points] == list(range(100))


def test_equal_points_and_lines_of_points_are_no_harm() -> None:
    points = np.zeros((200, 2))
    points[100:, 0] = np.arange(100)
    trees = planted(points, np.full(2, np.inf))
    assert nearest(trees, np.array([57.2, 0.0]), -1, np.inf)[0] == 157
    assert nearest(trees, np.array([-1.0, 0.0]), -1, np.inf)[1] == 1.0


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 1e60])
def test_points_that_are_not_finite_do_no_harm(wrong: float) -> None:
    random, period = np.random.default_rng(0), np.array([np.inf, 2.0, np.inf])
    points = random.uniform(-1, 1, (3000, 3))
    points[::3, 1], points[1::6, 0] = wrong, wrong
    finite = (np.abs(points) < 2.0).all(axis=1)
    tree = planted(points, period)
    for query in random.uniform(-1, 1, (100, 3)):
        squares = np.where(finite, square(points, query, period), np.inf)
        assert nearest(tree, query, -1, np.inf, EXACT)[0] == squares.argmin()
    assert nearest(tree, np.full(3, np.nan), 77, np.inf)[0] == 77


def test_nothing_beyond_the_best_so_far_is_found() -> None:
    trees = planted(np.array([[1.0], [2.0]]), np.full(1, np.inf))
    assert nearest(trees, np.zeros(1), 77, 0.5)[0] == 77
    assert nearest(Record(r_tree(10, np.full(1, np.inf))), np.zeros(1), 77, np.inf)[0] == 77


@pytest.mark.parametrize("kinds", [1, 2, 3, 50, 10**9])
@pytest.mark.parametrize("length", [1, 2, 3, 31, 34, 500])
def test_a_partition_puts_what_is_smaller_first(kinds: int, length: int) -> None:
    random = np.random.default_rng(kinds)
    values = random.integers(0, kinds, (600, 2)).astype(float)
    for at in {0, length // 3, length // 2, length - 1}:
        order = random.permutation(600)
        kept = order.copy()
        partition_median(values, 1, order, 50, 50 + length - 1, 50 + at)
        sorted_part = values[order[50 : 50 + length], 1]
        assert sorted_part[: at + 1].max() == sorted_part[at] == sorted_part[at:].min()
        assert sorted(order[50 : 50 + length]) == sorted(kept[50 : 50 + length])
        np.testing.assert_array_equal(
            np.delete(order, slice(50, 50 + length)), np.delete(kept, slice(50, 50 + length))
        )
