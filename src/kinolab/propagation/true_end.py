"""Where the true motion ends, without following it as closely as the verifier does."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.kernel import kernel
from kinolab.motion import DivergedError, resimulate
from kinolab.problem import Problem
from kinolab.propagation.machine_calls import advance, machine_of
from kinolab.records import Record

Array: TypeAlias = NDArray[np.float64]

SUBSTEPS = (8, 16)  # of a step


def true_excess(problem: Problem, u: Array) -> float:
    """Return how far outside the goal the true motion from the problem's start ends, in tolerances.

    Whether it ends inside is told by compiled steps where two lengths of them agree that it does;
    else the motion is followed as the verifier does. Infinite where that cannot be done.

    Args:
        problem: With the start and the goal.
        u: Inputs, one row per step, shape (N, nu).
    """
    if problem.scenario.integration.truth == "continuous":
        coarse, fine = (_excess(problem, u, "rk4", substeps) for substeps in SUBSTEPS)
        if max(coarse, fine) + abs(coarse - fine) < 1.0:
            return fine
    try:
        t = problem.step * np.arange(len(u) + 1.0)
        return problem.goal_excess(resimulate(problem, t, u).x[-1])
    except DivergedError:
        return math.inf


def _excess(problem: Problem, u: Array, method: str, substeps: int) -> float:
    step = problem.model.address(f"step_{method}")
    machine = Record(machine_of(problem)._replace(step=step, substeps=substeps))
    x, after = problem.start.copy(), np.zeros(problem.model.nx)
    failed = follow(machine, x, np.ascontiguousarray(u), problem.step, after)
    return math.inf if failed else problem.goal_excess(x)


@kernel
def follow(machine, x, u, h, after):  # type: ignore[no-untyped-def]
    """Follow inputs (N, nu) from x (nx,), which is written; 0 if it worked."""
    failed = 0
    for k in range(u.shape[0]):
        failed |= advance(machine, x, u[k], h, after)
        for i in range(x.shape[0]):
            x[i] = after[i]
    return failed
