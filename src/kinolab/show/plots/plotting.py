"""All plots of a plan, as files; phase portraits are drawn here."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from kinolab.dynamics.model.units import state_units
from kinolab.dynamics.symbols.symbols import Coordinate
from kinolab.problem import PlanningTask
from kinolab.show.plots.figure import GOAL, PLAN, START, WIDTH, figure_of, label
from kinolab.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.figure import Figure

import numpy as np

from kinolab.errors import InputError, Mistake
from kinolab.problem.unwrapping import unwrapped
from kinolab.runs import PLOT_NAMES
from kinolab.search.graph import SearchGraph
from kinolab.show.plots.configuration_plane import configuration_plane
from kinolab.show.plots.figure import Format, written
from kinolab.show.plots.timelines import inputs_over_time, states_over_time


def plots(
    problem: PlanningTask,
    trajectory: Trajectory,
    graph: SearchGraph | None = None,
    *,
    form: Format = "svg",
    plane: tuple[str, str] | None = None,
) -> dict[str, bytes]:
    """Return all plots of a plan, as files by name.

    Args:
        graph: The search graph, drawn in the configuration plane.
        form: SVG or PNG.
        plane: Coordinates of the configuration plane; those in which the plan moves most if left
            out.

    Raises:
        InputError: If there is no such coordinate, or a value is too large to be drawn.
    """
    _check_size(trajectory)
    title, trajectory = problem.scenario.title, unwrapped(problem, trajectory)
    figures = (
        states_over_time(problem, trajectory, title),
        inputs_over_time(problem, trajectory, title),
        phase_portraits(problem, trajectory, title),
        configuration_plane(problem, trajectory, graph, title, plane),
    )
    return {
        f"{name}.{form}": written(figure, form)
        for name, figure in zip(PLOT_NAMES, figures, strict=True)
        if figure is not None
    }


def _check_size(trajectory: Trajectory) -> None:
    """Reject numbers too large for axes; line 1 of a plan's file is its header."""
    t, x, u = trajectory.t[:, None], trajectory.x, trajectory.u
    columns = {("t",): t, trajectory.state_names: x, trajectory.control_names: u}
    # 1e150: magnitude that can be drawn; larger numbers overflow when squared
    mistakes = [
        Mistake(
            f"trajectory.csv line {row + 2} column {names[column]}",
            f"{table[row, column]:g} is too large to be drawn.",
        )
        for names, table in columns.items()
        for row, column in np.argwhere(np.abs(table) > 1e150)
    ]
    if mistakes:
        raise InputError(mistakes[:10])


def phase_portraits(problem: PlanningTask, trajectory: Trajectory, title: str) -> Figure | None:
    """Plot rate over coordinate wherever both are states; None if no rate is a state."""
    pairs = _pairs(problem)
    if not pairs:
        return None
    across = min(len(pairs), 3)  # per row
    rows = math.ceil(len(pairs) / across)
    figure, table = figure_of(rows, across, (WIDTH, 0.5 + 2.2 * rows), title)  # inches of each
    names, units = trajectory.state_names, state_units(problem.model)
    for axes, (place, rate) in zip(table, pairs, strict=False):
        q, v = trajectory.x[:, place], trajectory.x[:, rate]
        axes.plot(q, v, color=PLAN, linewidth=1.2)
        axes.plot(q[0], v[0], "o", color=START, markersize=5)
        axes.plot(q[-1], v[-1], "s", color=GOAL, markersize=5)
        axes.set(xlabel=label(names[place], units[place]), ylabel=label(names[rate], units[rate]))
    for axes in table[len(pairs) :]:
        axes.remove()
    return figure


def _pairs(problem: PlanningTask) -> list[tuple[int, int]]:
    """Return the columns of each coordinate on a line or a circle, and of its rate."""
    names = problem.model.state_names
    rates = {
        coordinate.name: f"{coordinate.name}_dot"
        for coordinate in problem.system.coordinates
        if isinstance(coordinate, Coordinate)
    }
    return [(names.index(name), names.index(rate)) for name, rate in rates.items() if rate in names]
