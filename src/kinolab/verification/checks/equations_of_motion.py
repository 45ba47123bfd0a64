"""Check that a second derivation of the equations of motion agrees with the one that is compiled.

All other checks follow the compiled equations: a mistake in their derivation would confirm itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from kinolab.dynamics.model.second_derivation import SecondDerivation
from kinolab.errors import SingularError
from kinolab.numerics.arrays import Array
from kinolab.verification.checks.check import Check, CheckContext, judged

AGREEMENT = 1e-8  # of the largest change of the state and a scale a second; rounding is below 1e-12
ROWS_PER_BATCH = 256


def equations(context: CheckContext) -> Check | None:
    """Compare both derivations at a sample of rows, or at every step of the integrator.

    None of a plan without a step.
    """
    if not len(context.stored.u):
        return None
    plant = context.problem.model.plant
    second, scales = SecondDerivation(plant), context.problem.scales
    worst, detail = 0.0, ""
    for times, x, u in _instants(context):
        try:
            first = plant.f(x, u)
        except SingularError as error:
            return Check("equations", math.inf, AGREEMENT, False, str(error))
        other = second.derivative(x, u)
        sizes = scales + np.abs(first).max(axis=1, keepdims=True)
        errors = np.nan_to_num(np.abs(first - other) / sizes, nan=math.inf)
        k, i = map(int, np.unravel_index(int(errors.argmax()), errors.shape))
        if errors[k, i] > worst:
            worst = float(errors[k, i])
            named = f"the derivative of {plant.state_names[i]} is {first[k, i]:.9g}"
            detail = f"at t = {times[k]:.6g} s {named}, derived a second way {other[k, i]:.9g}"
    return judged("equations", worst, AGREEMENT, detail)


def _instants(context: CheckContext) -> Iterator[tuple[Array, Array, Array]]:
    """Yield times (m,), states (m, nx) and inputs of the plant (m, nu) at which to compare."""
    t, x, u = context.trajectory.t, context.trajectory.x, context.stored.u
    if not context.thorough:
        # rows that are compared unless the whole motion is
        rows = np.unique(np.linspace(0, len(u) - 1, 12).round().astype(int))
        yield t[rows], x[rows], u[rows]
        return
    intervals, begin, _ = context.motion.steps
    for first in range(0, len(begin), ROWS_PER_BATCH):
        part = slice(first, first + ROWS_PER_BATCH)
        states = context.motion.along(intervals[part], begin[part])
        yield begin[part], states, u[intervals[part]]
