"""Phase portraits: each rate over its coordinate."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from kinolab.dynamics.language.symbols import Coordinate
from kinolab.dynamics.units import state_units
from kinolab.problem import PlanningTask
from kinolab.show.plots.figure import GOAL, PLAN, START, WIDTH, figure_of, label
from kinolab.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PORTRAITS_PER_ROW = 3  # per row
HEIGHT = 2.2  # inches of each


def phase_portraits(problem: PlanningTask, trajectory: Trajectory, title: str) -> Figure | None:
    """Plot rate over coordinate wherever both are states; None if no rate is a state."""
    pairs = _pairs(problem)
    if not pairs:
        return None
    across = min(len(pairs), PORTRAITS_PER_ROW)
    rows = math.ceil(len(pairs) / across)
    figure, table = figure_of(rows, across, (WIDTH, 0.5 + HEIGHT * rows), title)
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
