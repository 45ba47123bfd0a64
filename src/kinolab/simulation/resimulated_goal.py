"""Re-simulated goal check: does the reference motion end in the goal? Cheaper than verifying."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.machine import states_under
from kinolab.simulation.reference import (
    MAX_ERROR_AMPLIFICATION,
    DivergedError,
    error_amplification,
    perturbed_start,
    resimulate,
)

SUBSTEPS = (8, 16)  # per propagation step
MISSED = "missed_the_goal_in_truth"  # its key in planner statistics
BROKEN = "broken_in_truth"


@dataclass
class TrueEnds:
    """Re-simulates motions that reach the goal by a planner's steps; counts those rejected.

    Attributes:
        problem: Provides start and goal.
        missed: How many end outside the goal when re-simulated.
        broken: How many diverge, collide or amplify errors too much.
    """

    problem: PlanningTask
    missed: int = 0
    broken: int = 0

    def excess(self, u: Array) -> float:
        """Return ``resimulated_violation`` of inputs (N, nu)."""
        excess = resimulated_violation(self.problem, u)
        self.broken += math.isinf(excess)
        self.missed += 1.0 < excess < math.inf
        return excess

    @property
    def refused(self) -> int:
        """Total number of rejections."""
        return self.missed + self.broken

    @property
    def statistics(self) -> dict[str, float]:
        """Counts under the keys of planner statistics."""
        return {MISSED: float(self.missed), BROKEN: float(self.broken)}


def resimulated_violation(problem: PlanningTask, u: Array) -> float:
    """Return the goal violation at the end of the re-simulated motion, in tolerances.

    Uses compiled steps where two step lengths agree on the outcome, else the verifier's
    integrator. Infinite where the integration diverges, and for a motion into the goal that
    collides on its way or amplifies errors too much.

    Args:
        u: Inputs, one row per step, shape (N, nu).
    """
    if problem.scenario.integration.truth == "discrete":
        return _end(problem, states_under(problem, u))
    method = problem.scenario.integration.accurate_method
    states = [states_under(problem, u, substeps=substeps, method=method) for substeps in SUBSTEPS]
    coarse, fine = (_end(problem, one) for one in states)
    doubt = abs(coarse - fine)
    if not (max(coarse, fine) + doubt < 1.0 or min(coarse, fine) - doubt > 1.0):
        try:
            followed = resimulate(problem, problem.step * np.arange(len(u) + 1.0), u)
        except DivergedError:
            return math.inf
        fine, states[1] = problem.goal_excess(followed.x[-1]), followed.x
    return fine if fine > 1.0 or _holds(problem, states[1], u) else math.inf


def _end(problem: PlanningTask, states: Array) -> float:
    end = states[-1]
    return problem.goal_excess(end) if np.isfinite(end).all() else math.inf


def _holds(problem: PlanningTask, states: Array, u: Array) -> bool:
    """Return whether re-simulated states (N+1, nx) are collision-free and reproducible."""
    ends = problem.model.cables(states) if problem.cables else None
    if problem.checker().first_collision(problem.model.frames(states), ends) is not None:
        return False
    method = problem.scenario.integration.accurate_method
    far = states_under(problem, u, perturbed_start(problem, problem.start), method, SUBSTEPS[-1])
    return error_amplification(problem, states, far) <= MAX_ERROR_AMPLIFICATION
