"""All plots of a plan, as files."""

from __future__ import annotations

import numpy as np

from kinolab.errors import InputError, Mistake
from kinolab.problem import PlanningTask
from kinolab.problem.unwrapping import unwrapped
from kinolab.runs import PLOT_NAMES
from kinolab.search.graph import SearchGraph
from kinolab.show.plots.configuration_plane import configuration_plane
from kinolab.show.plots.figure import Format, written
from kinolab.show.plots.phase_portrait import phase_portraits
from kinolab.show.plots.timelines import inputs_over_time, states_over_time
from kinolab.trajectory import Trajectory

LARGEST = 1e150  # magnitude that can be drawn; larger numbers overflow when squared


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
        problem: The problem of the plan.
        trajectory: The plan.
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
    mistakes = [
        Mistake(
            f"trajectory.csv line {row + 2} column {names[column]}",
            f"{table[row, column]:g} is too large to be drawn.",
        )
        for names, table in columns.items()
        for row, column in np.argwhere(np.abs(table) > LARGEST)
    ]
    if mistakes:
        raise InputError(mistakes[:10])
