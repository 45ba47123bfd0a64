"""Where the true motion ends, without following it as closely as the verifier does."""

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

SUBSTEPS = (8, 16)  # of a step
MISSED = "missed_the_goal_in_truth"  # what planners call it in their statistics
BROKEN = "broken_in_truth"


@dataclass
class TrueEnds:
    """Judges motions that a planner's steps bring into the goal, and counts those refused.

    Attributes:
        problem: With the start and the goal.
        missed: How many truly end outside the goal.
        broken: How many cannot be followed, touch something, or make errors grow too much.
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
        """All together."""
        return self.missed + self.broken

    @property
    def statistics(self) -> dict[str, float]:
        """By the names that planners give them."""
        return {MISSED: float(self.missed), BROKEN: float(self.broken)}


def resimulated_violation(problem: PlanningTask, u: Array) -> float:
    """Return how far outside the goal the true motion from the problem's start ends, in tolerances.

    Whether it ends inside is told by compiled steps where two lengths of them agree; else the
    motion is followed as the verifier does. Infinite where that cannot be done, and for a motion
    into the goal that truly touches something on its way, or that makes errors grow too much.

    Args:
        problem: With the start and the goal.
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
    """Say whether true states (N+1, nx) touch nothing and can be reached again."""
    ends = problem.model.cables(states) if problem.cables else None
    if problem.checker().first_collision(problem.model.frames(states), ends) is not None:
        return False
    method = problem.scenario.integration.accurate_method
    far = states_under(problem, u, perturbed_start(problem, problem.start), method, SUBSTEPS[-1])
    return error_amplification(problem, states, far) <= MAX_ERROR_AMPLIFICATION
