"""Plot of the executions around a plan: paths, and deviations over time."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kinolab.analyze.execute.execution import Execution
from kinolab.analyze.execute.execution_report import varied_text
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.scenario.toml_text import shortened
from kinolab.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes


COLOURS = {
    "reached": "#2a7de1",
    "missed": "#e0a100",
    "collided": "#d62728",
    "strayed": "#e377c2",
    "lost": "#7b3294",
}
TUBE_STYLE = (5.0, 95.0)  # percentiles
AXES = {"top": (0, 1), "front": (0, 2), "side": (1, 2)}  # across and up, by [render] view


def tube_png(problem: PlanningTask, plan: Trajectory, execution: Execution, title: str) -> bytes:
    """Return a PNG plot: paths from above or from the side, and deviations over time."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 4.8), layout="constrained")  # inches
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, width_ratios=[3, 2])
    _paths(left, problem, plan, execution)
    _deviations(right, plan, execution)
    reached = f"{execution.reached} of {execution.total} reached the goal"
    varied = shortened(varied_text(problem, execution.conditions), 120)
    figure.suptitle(f"{title}: {reached}\n{varied}", parse_math=False, usetex=False, fontsize=10)
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=110)
    return out.getvalue()


def _paths(axes: Axes, problem: PlanningTask, plan: Trajectory, execution: Execution) -> None:
    """Plot the paths of what moves, or of what touched something, and where runs failed."""
    shown = _shown(problem, execution)
    planned = _places(problem, plan.x, shown)
    across, up = _axes(problem, planned)
    for outline in _outlines(problem, across, up):
        axes.fill(*outline.T, color="#b8b8b8", linewidth=0)
    for run in execution.runs:
        path, colour = _places(problem, run.x, shown, run.parameters), COLOURS[run.outcome]
        axes.plot(path[:, across], path[:, up], color=colour, linewidth=0.6, alpha=0.5)
        if run.failure is not None:
            axes.plot(*path[run.failure.step][[across, up]], "x", color=colour, markersize=6)
    axes.plot(planned[:, across], planned[:, up], color="black", linewidth=1.6, label="plan")
    if execution.reached:
        axes.plot([], [], color=COLOURS["reached"], label=f"{execution.reached} reached the goal")
    for group in execution.failures[:4]:  # groups of failures that the picture names
        label = shortened(f"{group.count} {group.first.phrase}", 60)
        axes.plot([], [], color=COLOURS[group.first.outcome], marker="x", label=label)
    if problem.world.ground and up == 2:
        axes.axhline(0.0, color="#8a8a8a", linewidth=1.0)
    axes.set(
        xlabel=f"{'xyz'[across]} of {problem.bodies[shown].name} [m]",
        ylabel=f"{'xyz'[up]} [m]",
        aspect="equal",
    )
    axes.set_adjustable("datalim")
    axes.legend(loc="best", fontsize=8)


def _shown(problem: PlanningTask, execution: Execution) -> int:
    """Return the body whose paths are drawn: what fails most often, else the leading one."""
    names = [body.name for body in problem.bodies]
    failed = (body for group in execution.failures for body in group.first.bodies)
    moving = (names.index(name) for name in failed if name in names)
    return next((k for k in moving if problem.bodies[k].moves), problem.leading)


def _axes(problem: PlanningTask, planned: Array) -> tuple[int, int]:
    """Return the axes across and up: the view of [render], else those of largest extent."""
    view = problem.scenario.render.view
    if view in AXES:
        return AXES[view]
    across, up = sorted(np.argsort(np.ptp(planned, axis=0), kind="stable")[-2:].tolist())
    return across, up


def _places(
    problem: PlanningTask, x: Array, body: int, parameters: dict[str, float] | None = None
) -> Array:
    """Return the origins of a body at states (N, nx), shape (N, 3)."""
    frames = problem.model.frames(x, **(parameters or {})).reshape(len(x), -1, 3, 4)
    places: Array = frames[:, body, :, 3]
    return places


def _outlines(problem: PlanningTask, across: int, up: int) -> list[Array]:
    """Return the projections of obstacles along the third axis, as polygons (m, 2)."""
    outlines = []
    for obstacle in problem.world.obstacles:
        vertices, faces = obstacle.picture()
        corners = vertices[:, [across, up]]
        if obstacle.primitive is not None:
            try:
                outlines.append(corners[ConvexHull(corners).vertices])
            except QhullError:  # degenerate in this view
                continue
        else:
            outlines += list(corners[faces[:20_000]])  # most faces drawn per mesh
    return outlines


def _deviations(axes: Axes, plan: Trajectory, execution: Execution) -> None:
    """Plot the deviations of the states from the plan, as a band over time."""
    steps = len(plan.x)
    table: Array = np.full((len(execution.runs), steps), np.nan)
    for row, run in zip(table, execution.runs, strict=True):
        row[: min(steps, len(run.off))] = run.off[:steps]
    seen = ~np.isnan(table).all(axis=0)
    t = plan.t[seen]
    low, middle, high = np.nanpercentile(
        table[:, seen], [TUBE_STYLE[0], 50.0, TUBE_STYLE[1]], axis=0
    )
    axes.fill_between(t, low, high, color="#2a7de1", alpha=0.25, linewidth=0, label="5 to 95 %")
    axes.plot(t, middle, color="#2a7de1", label="median")
    axes.set(xlabel="t [s]", ylabel="off the plan, in large deviations ([metric])")
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="best", fontsize=8)
