"""Sets up the field of a problem: potentials and weights of the control points."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.search.potential.control_points import ControlPoint, control_points, place
from kinolab.search.potential.eikonal import NavigationFunction, cropped, navigation_function
from kinolab.search.potential.field import (
    AttractivePotential,
    Field,
    PointPotential,
    Repulsion,
    StraightLinePotential,
)
from kinolab.search.potential.interruptible import run_unless_cancelled
from kinolab.search.potential.workspace import grid_of, is_open, open_cells
from kinolab.simulation import Propagator


def plain_field(problem: PlanningTask, repulsion: Repulsion) -> Field:
    """Return the field with straight-line attraction."""
    points = control_points(problem)
    return Field(
        problem,
        _weighed(problem, points, [StraightLinePotential(p.goal) for p in points]),
        repulsion,
    )


def navigation_field(
    propagator: Propagator,
    repulsion: Repulsion,
    *,
    resolution: float,
    grid_memory: float,
    clearance_cost_radius: float,
    stop: Callable[[], bool],
) -> Field | None:
    """Return the field of navigation functions; None if cancelled.

    Args:
        propagator: Checks states of its problem for collisions.
        resolution: Edge of a cell in [m]; 0 to derive it from the body's width.
        grid_memory: Memory limit for the grid of one point, in [MB].
        clearance_cost_radius: See ``navigation_function``.
        stop: Whether to cancel; polled.
    """
    problem = propagator.problem
    points = control_points(problem)
    found: list[PointPotential] = []
    for point in points:
        edge = resolution or _edge(problem, point)
        path = _navigation(propagator, point, edge, grid_memory, clearance_cost_radius, stop)
        if path is None:
            return None
        found.append(path)
    return Field(problem, _weighed(problem, points, found), repulsion)


def _navigation(
    propagator: Propagator,
    point: ControlPoint,
    edge: float,
    grid_memory: float,
    clearance_cost_radius: float,
    stop: Callable[[], bool],
) -> NavigationFunction | None:
    """Return a point's navigation function; cells are halved while start and goal disconnect."""
    problem = propagator.problem
    grid = grid_of(problem, point, edge, grid_memory)
    free = open_cells(propagator, point, grid, stop)
    for _ in range(3):  # halvings of the cell's edge while start and goal are disconnected
        finer = grid_of(problem, point, grid.size / 2, grid_memory)
        if (
            free is None
            or is_open(problem, point, grid, free)
            or finer.size > 0.9 * grid.size  # ratio of edges above which refinement is pointless
        ):
            break
        grid, free = finer, open_cells(propagator, point, finer, stop)
    if free is None:
        return None
    part, cells = cropped(grid, free, point.goal)
    return run_unless_cancelled(
        lambda: navigation_function(cells, part, point.goal, clearance_cost_radius), stop
    )


def _edge(problem: PlanningTask, point: ControlPoint) -> float:
    spans = [high - low for low, high in problem.world.bounds.values()]
    finest = max(spans, default=1.0) / 200.0  # cells along a workspace at the default edge
    # default cell edge, of half the body's width
    return max(0.7 * float(np.sort(point.carrier.reach)[1]), finest, 1e-3)


def _weighed(
    problem: PlanningTask, points: list[ControlPoint], potentials: list[PointPotential]
) -> list[AttractivePotential]:
    """Weight potentials so that the end of a body with the farther goal leads.

    The machine then arrives facing the right way. A body that cannot move sideways would have no
    reason to turn if both ends were attracted equally.
    """
    start = problem.frames(problem.start)
    heights = []
    for point, potential in zip(points, potentials, strict=True):
        centre = place(point.carrier.centre, start[point.carrier.body][None])
        heights.append(float(potential(centre)[0][0]))
    pulls = []
    for k, (point, potential) in enumerate(zip(points, potentials, strict=True)):
        rivals = [j for j, other in enumerate(points) if other.carrier is point.carrier]
        leads = k == max(rivals, key=lambda j: heights[j])
        # weight of a body's trailing end, relative to 1 for the leading one
        pulls.append(AttractivePotential(point, potential, 1.0 if leads else 0.3))
    return pulls
