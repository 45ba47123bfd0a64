"""States, inputs and references over time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kinolab.interchange.motion_tables import Block, blocks
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.show.plots.figure import LIMIT, WIDTH, figure_of, label
from kinolab.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Line:
    """A quantity over time.

    Attributes:
        name: Its name.
        unit: Empty for pure numbers.
        values: At the knots, shape (N+1,), or held between them, shape (N,).
        limits: Lower and upper; infinite if there are none.
    """

    name: str
    unit: str
    values: Array
    limits: tuple[float, float]


def states_over_time(problem: PlanningTask, trajectory: Trajectory, title: str) -> Figure:
    """Plot all states, those of one unit and similar size together."""
    states, *_ = blocks(problem, trajectory)
    return _drawn(list(_lines(states, problem.bounds)), trajectory.t, title)


def inputs_over_time(problem: PlanningTask, trajectory: Trajectory, title: str) -> Figure | None:
    """Plot inputs and references; None if there are none."""
    _, *held = blocks(problem, trajectory)
    models = ((problem.whole or problem.model).plant, problem.model)
    parts = zip(held, models, strict=False)
    lines = [line for part, model in parts for line in _lines(part, model.control_bounds)]
    return _drawn(lines, trajectory.t, title) if lines and len(trajectory.u) else None


def _lines(part: Block, bounds: Array) -> Iterator[Line]:
    limits = map(tuple, bounds.tolist())
    return map(Line, part.names, part.units, part.values.T, limits)


def _drawn(lines: list[Line], t: Array, title: str) -> Figure:
    groups = _together(lines)
    size = (WIDTH, 0.5 + 1.5 * len(groups))  # inches of each plot
    figure, axes = figure_of(len(groups), 1, size, title)
    for own, group in zip(axes, groups, strict=True):
        _draw(own, group, t)
        own.sharex(axes[-1])
        own.tick_params(labelbottom=own is axes[-1])
    axes[-1].set_xlabel("t [s]")
    return figure


def _together(lines: list[Line]) -> list[list[Line]]:
    """Group quantities by plot: one unit, and similar sizes."""
    groups: list[list[Line]] = []
    for line in lines:
        fitting = (group for group in groups if all(_fit(line, other) for other in group))
        group = next(fitting, None)
        if group is None:
            groups.append([line])
        else:
            group.append(line)
    return groups


def _fit(line: Line, other: Line) -> bool:
    sizes = sorted(float(np.abs(entry.values).max(initial=0.0)) for entry in (line, other))
    # 8.0: largest ratio of sizes in one plot
    return line.unit == other.unit and sizes[1] <= 8.0 * sizes[0]


def _draw(axes: Axes, lines: list[Line], t: Array) -> None:
    for line in lines:
        if len(line.values) == len(t):
            axes.plot(t, line.values, label=line.name, linewidth=1.2)
        else:
            axes.stairs(line.values, t, label=line.name, linewidth=1.2, baseline=None)
    low, high = axes.get_ylim()
    room = 0.5 * (high - low)  # of a plot's height: farther limits are not drawn
    for limit in sorted({limit for line in lines for limit in line.limits}):
        if low - room <= limit <= high + room:
            axes.axhline(limit, color=LIMIT, linewidth=0.8, linestyle="--", zorder=0)
    axes.set_ylabel(label("", lines[0].unit).strip())
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=8)
