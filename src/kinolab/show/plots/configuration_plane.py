"""Plot of a plane of the configuration space: collisions, search graph and plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.dynamics.model.units import state_units
from kinolab.dynamics.symbols.symbols import Coordinate
from kinolab.errors import InputError, unknown_name
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.search.graph import SearchGraph
from kinolab.show.plots.figure import GOAL, PLAN, START, WIDTH, figure_of, label
from kinolab.trajectory import Trajectory
from kinolab.world import NO_ENDS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


CELLS = 100  # of the grid along each axis
PLOT, FLATTEST = 0.7, 0.15  # height over width: of a plot, and minimum of a map


def configuration_plane(
    problem: PlanningTask,
    trajectory: Trajectory,
    graph: SearchGraph | None,
    title: str,
    plane: tuple[str, str] | None = None,
) -> Figure | None:
    """Plot two coordinates against each other; None if the machine has only one.

    Grey cells collide, the darker the more often, with all other coordinates taken from several
    states of the plan.

    Args:
        plane: Names of the coordinates; those in which the plan moves most if left out.

    Raises:
        InputError: If there is no such coordinate.
    """
    columns = _columns(problem, trajectory, plane)
    if columns is None:
        return None
    spans = [_span(problem, trajectory, graph, column) for column in columns]
    names, units = problem.model.state_names, state_units(problem.model)
    is_map, circular = all(units[k] == "m" for k in columns), problem.circular[columns]
    figure, (axes,) = figure_of(1, 1, (WIDTH, _height(spans, is_map)), title)
    fraction = _occupied(problem, trajectory, columns, spans)
    extent = (*spans[0], *spans[1])
    axes.imshow(
        fraction, cmap="Greys", vmin=0.0, vmax=1.4, extent=extent, origin="lower", aspect="auto"
    )
    if graph is not None:
        ends = graph.x[graph.edges][:, :, columns]
        _draw(axes, circular, _split(ends), color="#7fb4f0", linewidth=0.4, alpha=0.6)
    path = trajectory.x[:, columns]
    _draw(axes, circular, path, color=PLAN, linewidth=1.8)
    for k, color, marker in ((0, START, "o"), (-1, GOAL, "s")):
        style = {"marker": marker, "linestyle": "none", "markersize": 6}
        _draw(axes, circular, path[k][None], color=color, **style)
    across, up = (label(names[k], units[k]) for k in columns)
    axes.set(xlabel=across, ylabel=up, xlim=spans[0], ylim=spans[1])
    axes.grid(visible=False)
    if is_map:
        axes.set_aspect("equal")
    return figure


def _columns(
    problem: PlanningTask, trajectory: Trajectory, plane: tuple[str, str] | None
) -> list[int] | None:
    names = problem.model.state_names
    known = [q.name for q in problem.system.coordinates if isinstance(q, Coordinate)]
    if plane is not None:
        mistakes = [
            unknown_name("coordinate", name, known=known, where="--plane")
            for name in plane
            if name not in known
        ]
        if mistakes:
            raise InputError(mistakes)
        return [names.index(name) for name in plane]
    columns = np.array([names.index(name) for name in known], dtype=int)
    moved = np.ptp(trajectory.x[:, columns], axis=0) * problem.weights[columns]
    most = np.argsort(-moved, kind="stable")[:2]
    return sorted(columns[most].tolist()) if len(columns) > 1 else None


def _span(
    problem: PlanningTask, trajectory: Trajectory, graph: SearchGraph | None, column: int
) -> tuple[float, float]:
    if problem.circular[column]:
        return -np.pi, np.pi
    shown = [trajectory.x[:, column], problem.start[None, column]]
    shown += [] if graph is None else [graph.x[:, column]]
    low, high = np.concatenate(shown).min(), np.concatenate(shown).max()
    room = 0.15 * max(high - low, 1e-3)  # relative to the extent of plan and search
    lower, upper = problem.bounds[column]
    return float(max(low - room, lower)), float(min(high + room, upper))


def _occupied(
    problem: PlanningTask,
    trajectory: Trajectory,
    columns: list[int],
    spans: list[tuple[float, float]],
) -> Array:
    """Return the fraction of the plan's states with which each cell collides, (CELLS, CELLS)."""
    middles = (np.arange(CELLS) + 0.5) / CELLS
    across, up = (low + (high - low) * middles for low, high in spans)
    # 6 states of the plan from which the other coordinates are taken
    places = np.linspace(0, len(trajectory.x) - 1, min(6, len(trajectory.x))).astype(int)
    found, collides = np.zeros((CELLS, CELLS)), problem.checker().collides
    for x in trajectory.x[places]:
        states = np.repeat(x[None], CELLS * CELLS, axis=0)
        states[:, columns[0]] = np.tile(across, CELLS)
        states[:, columns[1]] = np.repeat(up, CELLS)
        frames = problem.model.frames(states)
        ends = problem.model.cables(states) if problem.cables else [NO_ENDS] * len(states)
        found += np.reshape([*map(collides, frames, ends)], (CELLS, CELLS))
    return found / len(places)


def _split(ends: Array) -> Array:
    """Return segments (m, 2, 2) as one line with gaps, shape (3 m, 2)."""
    gaps = np.full((len(ends), 1, 2), np.nan)
    return np.concatenate([ends, gaps], axis=1).reshape(-1, 2)


def _draw(axes: Axes, circular: NDArray[np.bool_], line: Array, **style: Any) -> None:
    """Plot a line, broken where an angle wraps."""
    shown = np.where(circular, wrapped(line), line)
    jumps = (np.abs(np.diff(shown, axis=0)) > np.pi) & circular
    shown = np.insert(shown, np.flatnonzero(jumps.any(axis=1)) + 1, np.nan, axis=0)
    axes.plot(*shown.T, **style)


def _height(spans: list[tuple[float, float]], is_map: bool) -> float:
    """Return the height of the figure in inches: of a map with one scale, or of a plot."""
    (left, right), (low, high) = spans
    fraction = (high - low) / (right - left) if is_map else PLOT
    return 0.9 + WIDTH * min(max(fraction, FLATTEST), 1.0)
