"""States of the goal region in which the machine is at rest, and whether there are any."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from kinolab.dynamics.language.constraints import PositionConstraint
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask

MAX_SAMPLES = 40
# evaluations of one search for a configuration whose points are at their targets
MAX_EVALUATIONS = 200


@dataclass(frozen=True, eq=False)
class GoalStates:
    """What was found of the goal region.

    Attributes:
        inside: States in it, each of shape (nx,).
        nearest: The state that comes nearest to it, or one in it.
    """

    inside: tuple[Array, ...]
    nearest: Array


def goal_states(problem: PlanningTask) -> GoalStates:
    """Draw states in the goal region; velocities that the goal leaves free are zero.

    Where the goal is about points and directions of bodies, or the machine has loops,
    configurations are searched for by bounded least squares.
    """
    generator = np.random.default_rng(0)
    states = [_at_rest(problem, x) for x in _guesses(problem, generator)]
    if problem.goal.needs_frames or has_loops(problem):
        states = [_reached(problem, x) for x in states]
    excesses = [problem.goal_excess(x) for x in states]
    inside = tuple(x for x, excess in zip(states, excesses, strict=True) if excess <= 1.0)
    return GoalStates(inside, states[int(np.argmin(excesses))])


def _guesses(problem: PlanningTask, generator: np.random.Generator) -> list[Array]:
    """Return the start moved to the targets' centre, then random states of the goal's box."""
    center = problem.start.copy()
    center[list(problem.goal.indices)] = problem.goal.targets
    for attitude in problem.goal.attitudes:
        center[attitude.entries] = attitude.target
    return [center, *(problem.sample_goal(generator) for _ in range(MAX_SAMPLES))]


def _at_rest(problem: PlanningTask, x: Array) -> Array:
    """Return a state without the velocities that the goal leaves free, on the constraints."""
    model, still = problem.model, x.copy()
    for i in range(model.nq, model.nx):
        if i not in problem.goal.indices:
            still[i] = 0.0
    return model.project(np.clip(still, *problem.bounds.T))


def _reached(problem: PlanningTask, guess: Array) -> Array:
    """Move a configuration, its loops being closed, to where the goal wants it."""
    nq = problem.model.nq
    lower, upper = problem.bounds[:nq].T
    lower, upper = (
        np.where(problem.circular[:nq], end, limit)
        for end, limit in ((-np.inf, lower), (np.inf, upper))
    )

    def state(q: Array) -> Array:
        return problem.model.project(np.concatenate([q, guess[nq:]]))

    found = least_squares(
        lambda q: problem.goal_residual(state(q)),
        np.clip(guess[:nq], lower, upper),
        bounds=(lower, upper),
        max_nfev=MAX_EVALUATIONS,
    )
    return state(found.x)


def has_loops(problem: PlanningTask) -> bool:
    """Whether some function of the machine's position must stay zero."""
    return any(isinstance(entry, PositionConstraint) for entry in problem.system.constraints)
