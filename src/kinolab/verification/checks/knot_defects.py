"""Defects of the stored knots against the re-simulated motion, and its error growth."""

from __future__ import annotations

import math

import numpy as np

from kinolab.errors import SingularError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import (
    MAX_ERROR_AMPLIFICATION,
    DivergedError,
    follow_each,
)
from kinolab.verification.between_samples.dense_motion import TooFastError
from kinolab.verification.checks.check import (
    LIMIT_TOLERANCE,
    Check,
    CheckContext,
    judged,
    worst_entry,
)

# of a state's scale: allowed defect between a knot and the state propagated from the one before
DEFECT_TOLERANCE = 1e-6


def start(context: CheckContext) -> Check:
    """Compare the first knot with the problem's start."""
    found, wanted = context.trajectory.x[:1], context.problem.start[None]
    errors = _errors(context.problem, found, wanted)
    return worst_entry(
        "start", errors, LIMIT_TOLERANCE, lambda k, i: _named(context, i, found[k], wanted[k])
    )


def dynamics(context: CheckContext) -> Check:
    """Integrate from each stored knot to the next, in short steps, and compare.

    With feedback, the stored inputs are applied, not the references. In no step does a point move
    further than ``MAX_SPACING``, so that the integrator cannot step over what the machine meets.
    """
    problem, trajectory = context.problem, context.trajectory
    discrete = problem.scenario.integration.truth == "discrete"
    # where the discrete integrator map is the reference
    limit = 1e-9 if discrete else DEFECT_TOLERANCE
    try:
        reached = _from_each(context)
    except (DivergedError, TooFastError) as error:
        return Check("dynamics", math.inf, limit, False, str(error))
    t, x = trajectory.t[1:], trajectory.x[1:]

    def words(k: int, i: int) -> str:
        return f"at t = {t[k]:.6g} s {_named(context, i, x[k], reached[k])}"

    return worst_entry("dynamics", _errors(problem, x, reached), limit, words)


def error_growth(context: CheckContext) -> Check:
    """Check by how much a perturbation of the start grows until the end."""
    growth, detail = context.error_growth
    return judged("error growth", growth, MAX_ERROR_AMPLIFICATION, detail)


def drift(context: CheckContext) -> Check:
    """Compare the stored knots with the motion from the start.

    Each knot may add a defect, and each defect is amplified by the error growth of the motion.
    """
    trajectory, (growth, _) = context.trajectory, context.error_growth
    errors = _errors(context.problem, trajectory.x, context.motion.x)
    # of a state's scale: beyond it the stored knots are not this motion
    limit = min(DEFECT_TOLERANCE * len(trajectory.t) * max(growth, 1.0), 1e-3)
    return worst_entry(
        "drift", errors, limit, lambda k, _: f"largest at t = {trajectory.t[k]:.6g} s"
    )


def _errors(problem: PlanningTask, found: Array, wanted: Array) -> Array:
    """Return absolute differences of states (n, nx), scaled by the states' scales."""
    return np.abs(problem.space.difference(wanted, found) / problem.scales)


def _named(context: CheckContext, i: int, found: Array, wanted: Array) -> str:
    name = context.problem.model.state_names[i]
    return f"{name} is {found[i]:.9g} where {wanted[i]:.9g} is due"


def _from_each(context: CheckContext) -> Array:
    """Return the states reached from each stored knot under its stored input, (N, nx)."""
    problem, trajectory = context.problem, context.trajectory
    plant, settings = problem.model.plant, problem.scenario.integration
    t, x, u = trajectory.t, trajectory.x, trajectory.u
    if settings.truth != "discrete":
        longest = context.dense_motion.longest_steps
        return follow_each(plant, x[:-1], t, u, problem.scales, longest)
    try:
        return plant.step(x[:-1], u, np.diff(t), method=settings.method, substeps=settings.substeps)
    except SingularError as error:
        raise DivergedError(float(t[error.row]), str(error)) from error
