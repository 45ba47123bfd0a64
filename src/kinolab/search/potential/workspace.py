"""Free workspace of a control point: cells that it can reach without collision.

If length coordinates move the point, the machine itself is checked in each cell in several
attitudes: the cell is free if one of them is, so only the sampling of attitudes can exclude a
feasible path. Otherwise (an arm) only the largest ball about the point inside the body is checked.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from kinolab.dynamics.language.shapes import Sphere
from kinolab.numerics.arrays import Array
from kinolab.numerics.work import charge
from kinolab.problem import PlanningTask
from kinolab.search.potential.control_points import ControlPoint, place
from kinolab.search.potential.eikonal import Mask, WorkspaceGrid
from kinolab.search.potential.leading_bodies import sample_states
from kinolab.simulation import Propagator
from kinolab.world import BodyGeometry, CollisionChecker
from kinolab.world.shapes.geometry import placement

RANDOM_ATTITUDES = 16  # checked per cell
RANDOM_STATES = 32  # configurations that determine the extent of the workspace
MIN_MOTION = 1e-6  # [m] extent from which an axis belongs to the workspace
CELLS_PER_CANCELLATION_CHECK = 16  # cells between cancellation checks


def grid_of(
    problem: PlanningTask, point: ControlPoint, resolution: float, grid_memory: float
) -> WorkspaceGrid:
    """Return the grid of a point's workspace, aligned so that the goal is a corner of cells.

    Args:
        resolution: Edge of a cell in [m]; increased to fit the memory limit.
        grid_memory: Memory limit for all cells, in [MB].
    """
    low, high = _extent(problem, point)
    axes = tuple(int(k) for k in np.flatnonzero(high - low > MIN_MOTION))
    low, high, goal = (values[list(axes)] for values in (low, high, point.goal))
    # occupancy, speeds and values, with the solver's own arrays
    most = max(grid_memory * 1e6 / 64, 2.0 ** len(axes))
    size = resolution
    while True:
        below, above = (
            np.maximum(np.ceil((s - 1e-9) / size), 1) for s in (goal - low, high - goal)
        )
        if np.prod(below + above) <= most:
            break
        size *= 1.05
    return WorkspaceGrid(axes, goal - size * below, size, tuple(int(n) for n in below + above))


def _extent(problem: PlanningTask, point: ControlPoint) -> tuple[Array, Array]:
    """Estimate the bounds of a point's positions by sampling, shape (3,) each, in [m]."""
    states = sample_states(problem, RANDOM_STATES)
    for k, entry in enumerate(point.carrier.lengths):
        for half, value in zip((0, 1), problem.sampling_bounds[entry], strict=True):
            # All combinations of the lengths' limits.
            states[(np.arange(RANDOM_STATES) >> k) % 2 == half, entry] = value
    places = place(point.at, problem.frames(states)[:, point.carrier.body])
    places = np.vstack([places, point.goal, _at(problem, point, problem.start)])
    low, high = places.min(axis=0), places.max(axis=0)
    for axis, (lower, upper) in problem.world.bounds.items():
        k = "xyz".index(axis)
        if high[k] - low[k] > MIN_MOTION:
            low[k], high[k] = max(low[k], lower), min(high[k], upper)
    return low, high


def open_cells(
    propagator: Propagator, point: ControlPoint, grid: WorkspaceGrid, stop: Callable[[], bool]
) -> Mask | None:
    """Return the mask of free cells connected to the point's goal, of the grid's shape.

    It is a flood fill from the goal, so no other cells are checked. None if cancelled.
    """
    is_free = _judge(propagator, point, grid)
    free, seen = np.zeros(grid.shape, dtype=bool), np.zeros(grid.shape, dtype=bool)
    front, judged = around_goal(grid, point.goal), 0
    for cell in front:
        seen[cell] = free[cell] = True
    while front:
        cell = front.pop()
        for neighbour in _neighbours(cell, grid.shape):
            if seen[neighbour]:
                continue
            seen[neighbour] = True
            judged += 1
            if judged % CELLS_PER_CANCELLATION_CHECK == 0:
                # [s] that checking a cell takes, as ``charge`` counts it
                charge(8e-5 * CELLS_PER_CANCELLATION_CHECK)
                if stop():
                    return None
            if is_free(grid.centre(neighbour)):
                free[neighbour] = True
                front.append(neighbour)
    return free


def is_open(problem: PlanningTask, point: ControlPoint, grid: WorkspaceGrid, free: Mask) -> bool:
    """Say whether the start is in a free cell or next to one."""
    cell = grid.cell_of(_at(problem, point, problem.start))
    around = tuple(slice(max(k - 1, 0), k + 2) for k in cell)
    return bool(free[around].any())


def around_goal(grid: WorkspaceGrid, goal: Array) -> list[tuple[int, ...]]:
    """Return the cells that have the goal, shape (3,), as a corner."""
    upper = np.rint((goal[list(grid.axes)] - grid.origin) / grid.size).astype(int)
    cells = (tuple(int(i) for i in upper - step) for step in np.ndindex(*(2,) * len(upper)))
    return [c for c in cells if all(0 <= i < n for i, n in zip(c, grid.shape, strict=True))]


def _neighbours(cell: tuple[int, ...], shape: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
    for k, size in enumerate(shape):
        if cell[k] > 0:
            yield (*cell[:k], cell[k] - 1, *cell[k + 1 :])
        if cell[k] + 1 < size:
            yield (*cell[:k], cell[k] + 1, *cell[k + 1 :])


def _judge(
    propagator: Propagator, point: ControlPoint, grid: WorkspaceGrid
) -> Callable[[Array], bool]:
    """Return the predicate whether the point may be at a position (axes,) of the grid."""
    problem = propagator.problem
    states = _attitudes(problem)
    steps, ball_fits = _carried(problem, point, grid, states), _ball(problem, point, grid)
    if steps is None:
        return ball_fits
    lengths, axes = list(point.carrier.lengths), list(grid.axes)
    bodies = problem.frames(states)[:, point.carrier.body]
    offsets, latest = place(point.at, bodies)[:, axes], 0

    def brought(k: int, target: Array) -> bool:
        x = states[k].copy()
        x[lengths] += steps @ (target - offsets[k])
        return propagator.is_free(x.tolist())

    def is_free(target: Array) -> bool:
        nonlocal latest
        if brought(latest, target):
            return True
        if not ball_fits(target):
            return False  # nor does the body, in any attitude
        for k in range(len(states)):
            if k != latest and brought(k, target):
                latest = k  # most likely free in adjacent cells too
                return True
        return False

    return is_free


def _attitudes(problem: PlanningTask) -> Array:
    """Return states at rest in several attitudes: the start's, the goal's, and others; (n, nx).

    Angles that are not circular (sway, steering) stay as at the start.
    """
    generator = np.random.default_rng(0)
    states = np.tile(problem.start, (RANDOM_ATTITUDES + 2, 1))
    states[:, problem.model.nq :] = 0.0
    turning = np.flatnonzero(problem.circular)
    goal = problem.sample_goal(generator, spread=0.0)
    turned = np.flatnonzero(problem.space.turns)
    states[1, turned] = goal[turned]
    for k in range(RANDOM_ATTITUDES):
        for j, entry in enumerate(turning):
            # Equidistant for one angle, a lattice for several.
            states[k + 2, entry] = (
                2 * np.pi * ((k * (1 + 7 * j)) % RANDOM_ATTITUDES) / RANDOM_ATTITUDES - np.pi
            )
        for part in problem.space.spheres:
            states[k + 2, part.own] = part.random(generator)
    return problem.model.project(states if turned.size else states[:1])


def _carried(
    problem: PlanningTask, point: ControlPoint, grid: WorkspaceGrid, states: Array
) -> Array | None:
    """Return the Jacobian of the lengths in the point's position, shape (lengths, axes).

    None if the lengths do not move the point along every axis of the grid, or not linearly.
    """
    lengths, body, axes = point.carrier.lengths, point.carrier.body, list(grid.axes)
    if not lengths:
        return None
    base = place(point.at, problem.frames(states[:1])[:, body])
    moved = np.repeat(states[:1], 2 * len(lengths), axis=0)
    for k, entry in enumerate(lengths):
        moved[2 * k, entry] += 1.0
        moved[2 * k + 1, entry] += 2.0
    shift = place(point.at, problem.frames(moved)[:, body]) - base
    straight = np.allclose(2 * shift[0::2], shift[1::2], atol=MIN_MOTION)
    slopes = shift[0::2][:, axes].T  # (axes, lengths)
    if not straight or np.linalg.matrix_rank(slopes, tol=1e-6) < len(axes):
        return None
    return np.asarray(np.linalg.pinv(slopes), dtype=float)


def _ball(
    problem: PlanningTask, point: ControlPoint, grid: WorkspaceGrid
) -> Callable[[Array], bool]:
    """Return the check of the largest ball about the point inside the body, for the machine."""
    body = problem.bodies[point.carrier.body]
    # [m] radius of a ball that represents a point
    radius = max(inscribed_radius(body, point.at), 1e-3)
    ball = BodyGeometry("ball", (Sphere(radius),), body.touches_ground)
    checker = CollisionChecker([ball], problem.world)
    where, axes = point.goal.copy(), list(grid.axes)

    def is_free(target: Array) -> bool:
        where[axes] = target
        return not checker.collides(np.column_stack([np.eye(3), where]).reshape(1, 12))

    return is_free


def _at(problem: PlanningTask, point: ControlPoint, x: Array) -> Array:
    where: Array = place(point.at, problem.frames(x)[point.carrier.body][None])[0]
    return where


def inscribed_radius(body: BodyGeometry, at: Array) -> float:
    """Return the radius in [m] of the largest ball in a body about a point (3,) of its frame.

    It is that of the best single shape: the union of overlapping shapes might contain a larger one.
    It is 0 outside.
    """
    own = [(shape, placement(shape)) for shape in body.shapes]
    depths = [float(shape.depths(g[:, :3].T @ (at - g[:, 3]))) for shape, g in own]
    return max([0.0, *depths])
