"""Data for interactive simulation in a page, in which the user drives the machine."""

from __future__ import annotations

import numpy as np

from kinolab.dynamics import Model
from kinolab.dynamics.codegen.methods import METHODS
from kinolab.dynamics.javascript import javascript_of
from kinolab.numerics.arrays import Array, finite_or_none
from kinolab.problem import PlanningTask
from kinolab.problem.static_holding import static_holding
from kinolab.problem.time_steps import covering_steps
from kinolab.show.scene.content import Driving
from kinolab.trajectory import Trajectory


def driving_of(problem: PlanningTask, trajectory: Trajectory) -> Driving:
    """Return the machine as JavaScript, with its steps and start states.

    Args:
        problem: The machine, with input limits narrowed by [bounds].
        trajectory: The plan's stored states, from which driving may start.
    """
    settings, model = problem.scenario.integration, problem.model
    idle = _idle(problem)
    return Driving(
        code=javascript_of(model, implicit=METHODS[settings.method].implicit),
        states=trajectory.x,
        facts={
            "start": problem.start.tolist(),
            "step": driven_step(problem),
            "method": settings.method,
            "substeps": settings.substeps,
            "bounds": [[*map(finite_or_none, pair)] for pair in problem.bounds.tolist()],
            "closed": _hands(problem, model, idle),
            "plant": _hands(problem, model.plant, idle if model.plant is model else None),
        },
    )


def driven_step(problem: PlanningTask) -> float:
    """Return the hold time of inputs in [s]: the problem's step, or an equal part of it.

    Controllers and discrete machines are only defined at the problem's own step.
    """
    closed = problem.model.plant is not problem.model
    if closed or problem.scenario.integration.truth == "discrete":
        return problem.step
    # 1 / 30 [s]; longer holds make keys respond late
    return problem.step / covering_steps(problem.step, 1 / 30)


def _idle(problem: PlanningTask) -> Array:
    """Return the idle inputs, shape (nu,): those that hold the machine at its start, if any."""
    held = static_holding(problem, problem.start)
    if not (held and held.holds):
        return problem.model.null_control()
    return np.array([held.inputs[name] for name in problem.model.control_names])


def _hands(problem: PlanningTask, model: Model, idle: Array | None) -> dict[str, list[float]]:
    """Return idle inputs, and the fraction of the range to a limit that a key applies."""
    least = model.null_control() if idle is None else idle
    return {"idle": least.tolist(), "usual": _usual(problem, model, least).tolist()}


def _usual(problem: PlanningTask, model: Model, idle: Array) -> Array:
    """Return input fractions in (0, 1], shape (nu,), at which a person can drive."""
    # 0.5 of the range to a limit, if inputs are velocities or set points themselves
    shares = np.full(model.nu, 0.5)
    if model.plant is not model or not len(model.speeds):
        return shares
    _, slopes = model.jacobian(problem.start, idle)
    paths = np.abs(model.control_bounds - idle[:, None]).max(axis=1)
    paces = np.abs(slopes[model.speeds]) * paths / problem.scales[model.speeds, None]  # [1/s]
    fastest = paces.max(axis=0)
    moved = fastest > 0.0
    # 1.5 [s] in which a key drives the first speed to its limit
    shares[moved] = np.minimum(1.0, 1.0 / (1.5 * fastest[moved]))
    return shares
