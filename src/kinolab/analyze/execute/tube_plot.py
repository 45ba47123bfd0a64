"""Plot of the executions around a plan: paths, and deviations over time."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kinolab.analyze.execute.execution import Execution
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
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
FIGURE_SIZE = (11.0, 4.8)  # inches
TUBE_STYLE = (5.0, 95.0)  # percentiles
MAX_FACES = 20_000  # drawn per mesh


def tube_png(problem: PlanningTask, plan: Trajectory, execution: Execution, title: str) -> bytes:
    """Return a PNG plot: paths from above or from the side, and deviations over time.

    Args:
        problem: The problem of the plan.
        plan: The executed plan.
        execution: Its executions.
        title: Title of the plan.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=FIGURE_SIZE, layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, width_ratios=[3, 2])
    _paths(left, problem, plan, execution)
    _deviations(right, plan, execution)
    c, reached = execution.conditions, f"{execution.reached} of {execution.total} reached the goal"
    varied = f"parameters ±{c.parameters:.0%}, noise {c.noise:.1%}, disturbance {c.disturbance:.1%}"
    figure.suptitle(f"{title}: {reached} ({varied})", parse_math=False, usetex=False)
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=110)
    return out.getvalue()


def _paths(axes: Axes, problem: PlanningTask, plan: Trajectory, execution: Execution) -> None:
    """Plot the paths of the main body, along the two axes of largest extent."""
    planned = _places(problem, plan.x)
    across, up = sorted(np.argsort(np.ptp(planned, axis=0), kind="stable")[-2:].tolist())
    for outline in _outlines(problem, across, up):
        axes.fill(*outline.T, color="#b8b8b8", linewidth=0)
    for run in execution.runs:
        path = _places(problem, run.x, run.parameters)
        axes.plot(
            path[:, across], path[:, up], color=COLOURS[run.outcome], linewidth=0.6, alpha=0.5
        )
    axes.plot(planned[:, across], planned[:, up], color="black", linewidth=1.6, label="plan")
    for outcome in execution.counts:
        axes.plot([], [], color=COLOURS[outcome], label=f"{outcome}: {execution.counts[outcome]}")
    axes.set(xlabel=f"{'xyz'[across]} [m]", ylabel=f"{'xyz'[up]} [m]", aspect="equal")
    axes.legend(loc="best", fontsize=8)


def _places(problem: PlanningTask, x: Array, parameters: dict[str, float] | None = None) -> Array:
    """Return the origins of the heaviest body at states (N, nx), shape (N, 3)."""
    masses = [problem.system.number(body.mass) for body in problem.system.bodies]
    frames = problem.model.frames(x, **(parameters or {})).reshape(len(x), -1, 3, 4)
    places: Array = frames[:, int(np.argmax(masses)), :, 3]
    return places


def _outlines(problem: PlanningTask, across: int, up: int) -> list[Array]:
    """Return the projections of obstacles along the third axis, as polygons (m, 2)."""
    outlines = []
    for obstacle in problem.world.obstacles:
        corners = obstacle.vertices[:, [across, up]]
        if obstacle.primitive is not None:
            try:
                outlines.append(corners[ConvexHull(corners).vertices])
            except QhullError:  # degenerate in this view
                continue
        else:
            faces = obstacle.faces[:MAX_FACES]
            outlines += list(corners[faces])
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
    axes.set(xlabel="t [s]", ylabel="largest deviation, weighted")
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="best", fontsize=8)


def execution_to_json(execution: Execution) -> dict[str, Any]:
    """Return an execution as plain data; what is not finite becomes null."""
    return {
        "conditions": dict(vars(execution.conditions)),
        "seed": execution.seed,
        "runs": execution.total,
        "reached": execution.reached,
        "counts": execution.counts,
        "each": [
            {
                "outcome": run.outcome,
                "excess": run.excess if np.isfinite(run.excess) else None,
                "deviation": run.deviation if np.isfinite(run.deviation) else None,
                "steps": run.steps,
                "parameters": run.parameters,
            }
            for run in execution.runs
        ],
    }
