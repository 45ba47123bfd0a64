"""The navigation function: as long as the way is, and no minimum but the goal."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from kinolab.search.potential.eikonal import (
    MIN_SPEED,
    NavigationFunction,
    WorkspaceGrid,
    cropped,
    navigation_function,
)

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

CELL = 0.1  # [m]


def plane(*shape: int) -> WorkspaceGrid:
    return WorkspaceGrid((0, 1, 2)[: len(shape)], np.zeros(len(shape)), CELL, shape)


def at_corner(*cells: int) -> Array:
    """A corner of cells as a point of the world."""
    return np.array([*(CELL * k for k in cells), 0.0, 0.0])[:3]


def maze(seed: int, dims: int) -> tuple[Mask, Array]:
    """Random blocks of three cells, and a goal in the middle of one that is free."""
    generator = np.random.default_rng(seed)
    blocks = generator.random((14,) * dims if dims == 2 else (7,) * dims) < 0.65
    free: Mask = np.kron(blocks, np.ones((3,) * dims)) > 0
    block = generator.permutation(np.argwhere(blocks))[0]
    return free, at_corner(*(3 * block + 1))


def corners_of(free: Mask) -> Mask:
    found = np.zeros(tuple(n + 1 for n in free.shape), dtype=bool)
    for step in np.ndindex(*(2,) * free.ndim):
        found[tuple(slice(k, k + n) for k, n in zip(step, free.shape, strict=True))] |= free
    return found


def minima(way: NavigationFunction, free: Mask) -> Array:
    """Corners of free cells from which no neighbour along an axis is lower."""
    values = np.pad(way.values, 1, constant_values=np.inf)
    inner = (slice(1, -1),) * free.ndim
    lower = np.zeros(way.values.shape, dtype=bool)
    for axis in range(free.ndim):
        for step in (-1, 1):
            lower |= np.roll(values, step, axis)[inner] < way.values
    return np.argwhere(~lower & corners_of(free))


@pytest.mark.parametrize("shape", [(60, 50), (24, 20, 16)])
def test_in_the_open_it_is_the_straight_distance(shape: tuple[int, ...]) -> None:
    goal = at_corner(*(n // 3 for n in shape))
    way = navigation_function(
        np.ones(shape, dtype=bool), plane(*shape), goal, clearance_cost_radius=0.0
    )
    points = np.zeros((500, 3))
    top = CELL * np.array(shape)
    points[:, : len(shape)] = np.random.default_rng(0).uniform(0, top, (500, len(shape)))
    distance = np.linalg.norm((points - goal)[:, : len(shape)], axis=1)
    # Between corners a cone is interpolated: off by up to cell^2 / (8 distance) per axis, and the
    # solver's own error is of the same order; straight ways take over within two cells.
    assert np.abs(way(points)[0] - distance).max() < 0.2 * CELL


def test_around_a_corner_it_is_the_stretched_string() -> None:
    """A wall from y = 0 to 3; the shortest way touches both its upper corners."""
    free = np.ones((80, 60), dtype=bool)
    free[30:33, :30] = False
    goal = at_corner(10, 5)
    way = navigation_function(free, plane(80, 60), goal, clearance_cost_radius=0.0)
    left, right = np.array([3.0, 3.0]), np.array([3.3, 3.0])
    for point in ([7.0, 0.5, 0.0], [5.0, 1.0, 0.0], [7.5, 2.5, 0.0]):
        string = np.linalg.norm(left - goal[:2]) + 0.3 + np.linalg.norm(right - point[:2])
        value = float(way(np.array([point]))[0][0])
        assert value == pytest.approx(string, rel=0.01)  # first order: an error of O(cell)


@pytest.mark.parametrize("dims", [2, 3])
@pytest.mark.parametrize("berth", [0.0, 0.3])
@pytest.mark.parametrize("seed", range(6))
def test_a_maze_has_no_minimum_but_the_goal(seed: int, berth: float, dims: int) -> None:
    """All free cells are looked at, also those that the goal cannot be reached from."""
    free, goal = maze(seed, dims)
    way = navigation_function(free, plane(*free.shape), goal, berth)
    found = minima(way, free)
    assert found.tolist() == [np.rint(goal[:dims] / CELL).astype(int).tolist()]


@pytest.mark.parametrize("seed", range(3))
def test_between_corners_it_goes_down_as_well(seed: int) -> None:
    """Following the slope in small steps from anywhere reachable ends at the goal."""
    free, goal = maze(seed, 2)
    way = navigation_function(free, plane(*free.shape), goal, clearance_cost_radius=0.0)
    cells = np.argwhere(free)
    starts = np.random.default_rng(seed).permutation(cells)[:20]
    for cell in starts:
        point = np.array([[*(CELL * (cell + 0.5)), 0.0]])
        value = float(way(point)[0][0])
        if value > CELL * free.size:  # beyond a wall: nothing leads there
            continue
        for _ in range(5000):
            # Interpolated slopes may cross: the shortest step downhill is looked for around.
            angles = np.linspace(0, 2 * np.pi, 32, endpoint=False)
            ring = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
            trial = point + CELL / 4 * ring
            values = way(trial)[0]
            if values.min() >= value:
                break
            value, point = float(values.min()), trial[[int(values.argmin())]]
        assert np.linalg.norm(point[0] - goal) < CELL


@pytest.mark.parametrize("dims", [2, 3])
def test_its_slope_is_that_of_its_values(dims: int) -> None:
    """Inside a cell it is a polynomial: central differences are exact but for rounding."""
    free, goal = maze(1, dims)
    way = navigation_function(free, plane(*free.shape), goal, clearance_cost_radius=0.3)
    generator, h = np.random.default_rng(0), 1e-6
    cells = generator.permutation(np.argwhere(free))[:100]
    points = np.zeros((100, 3))
    points[:, :dims] = CELL * (cells + generator.uniform(0.1, 0.9, (100, dims)))
    slopes = way(points)[1]
    for axis in range(3):
        step = h * np.eye(3)[axis]
        numeric = (way(points + step)[0] - way(points - step)[0]) / (2 * h)
        # Beside the goal the straight way takes over, which is curved: h^2 / r^2 of the slope.
        size = np.abs(way(points)[0])
        assert np.abs(slopes[:, axis] - numeric).max() < 1e-6 + 1e-9 * size.max() / h


def test_a_clearance_cost_leads_ways_to_the_middle_of_a_corridor() -> None:
    free = np.ones((60, 20), dtype=bool)
    way = navigation_function(free, plane(60, 20), at_corner(55, 10), clearance_cost_radius=1.0)
    beside, middle = way(np.array([[0.5, 0.1, 0.0], [0.5, 1.0, 0.0]]))[0]
    assert beside > middle
    slope = way(np.array([[0.5, 0.3, 0.0]]))[1][0]
    assert slope[1] < -0.1  # away from the wall at y = 0, though the goal is straight ahead


def test_a_clearance_cost_makes_a_way_at_most_five_times_as_long() -> None:
    free, goal = maze(0, 2)
    short, wide = (
        navigation_function(free, plane(*free.shape), goal, berth) for berth in (0.0, 5.0)
    )
    cells = corners_of(free) & (short.values < CELL * free.size)
    assert (wide.values[cells] >= short.values[cells] * (1 - 1e-9)).all()
    assert (wide.values[cells] <= short.values[cells] / MIN_SPEED * (1 + 1e-6)).all()


def test_it_is_0_at_the_goal_and_keeps_its_edge_value_outside() -> None:
    free = np.ones((20, 20), dtype=bool)
    goal = at_corner(7, 9)
    way = navigation_function(free, plane(20, 20), goal, clearance_cost_radius=0.0)
    assert way(goal[None])[0] == pytest.approx(0.0, abs=1e-12)
    inside, outside = way(np.array([[2.0, 1.0, 0.0], [9.0, 1.0, 0.0]]))[0]
    assert outside >= inside


@pytest.mark.parametrize("dims", [2, 3])
def test_a_cropped_grid_knows_the_same_ways(dims: int) -> None:
    """Only cells that nothing leads to are left out."""
    free = np.zeros((30,) * dims, dtype=bool)
    free[(slice(8, 20),) * dims] = True
    free[(slice(10, 14),) * (dims - 1) + (slice(8, 15),)] = False
    goal, grid = at_corner(*(18,) * dims), plane(*free.shape)
    part, inside = cropped(grid, free, goal)
    assert inside.sum() == free.sum()
    assert inside.shape == (14,) * dims
    cells = np.argwhere(free)
    points = np.zeros((len(cells), 3))
    points[:, :dims] = CELL * (cells + 0.3)
    whole, cut = (
        navigation_function(free, grid, goal, 0.2),
        navigation_function(inside, part, goal, 0.2),
    )
    assert cut(points)[0] == pytest.approx(whole(points)[0], rel=1e-9)
