"""Where the true motion ends, without following it as closely as the verifier does."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.motion import DivergedError, resimulate
from kinolab.problem import Problem
from kinolab.propagation.machine_calls import motion_under

Array: TypeAlias = NDArray[np.float64]

SUBSTEPS = (8, 16)  # of a step


def true_excess(problem: Problem, u: Array) -> float:
    """Return how far outside the goal the true motion from the problem's start ends, in tolerances.

    Whether it ends inside is told by compiled steps where two lengths of them agree; else the
    motion is followed as the verifier does. Infinite where that cannot be done.

    Args:
        problem: With the start and the goal.
        u: Inputs, one row per step, shape (N, nu).
    """
    if problem.scenario.integration.truth == "continuous":
        coarse, fine = (_excess(problem, u, "rk4", substeps) for substeps in SUBSTEPS)
        doubt = abs(coarse - fine)
        if max(coarse, fine) + doubt < 1.0 or min(coarse, fine) - doubt > 1.0:
            return fine
    try:
        t = problem.step * np.arange(len(u) + 1.0)
        return problem.goal_excess(resimulate(problem, t, u).x[-1])
    except DivergedError:
        return math.inf


def _excess(problem: Problem, u: Array, method: str, substeps: int) -> float:
    end = motion_under(problem, u, method, substeps)[-1]
    return problem.goal_excess(end) if np.isfinite(end).all() else math.inf
