"""Rest states in the goal region, if there are any."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask


@dataclass(frozen=True, eq=False)
class GoalStates:
    """Samples of the goal region.

    Attributes:
        inside: States in the goal region, each of shape (nx,).
        nearest: The state with the smallest goal error.
    """

    inside: tuple[Array, ...]
    nearest: Array


def goal_states(problem: PlanningTask) -> GoalStates:
    """Sample states in the goal region; velocities that the goal leaves free are zero.

    If the goal constrains points or directions of bodies, or the machine has closed loops,
    configurations are found by bounded least squares.
    """
    generator = np.random.default_rng(0)
    states = [_at_rest(problem, x) for x in _guesses(problem, generator)]
    if problem.goal.needs_frames or problem.machine.closes_loops:
        states = [_reached(problem, x) for x in states]
    excesses = [problem.goal_excess(x) for x in states]
    inside = tuple(x for x, excess in zip(states, excesses, strict=True) if excess <= 1.0)
    return GoalStates(inside, states[int(np.argmin(excesses))])


def _guesses(problem: PlanningTask, generator: np.random.Generator) -> list[Array]:
    """Return the start moved to the goal's targets, then random samples of the goal box."""
    drawn = (problem.sample_goal(generator) for _ in range(40))
    return [problem.goal.centre(problem.start), *drawn]


def _at_rest(problem: PlanningTask, x: Array) -> Array:
    """Return a state with free velocities set to 0, projected onto the constraints."""
    model, still = problem.model, x.copy()
    for i in range(model.nq, model.nx):
        if i not in problem.goal.indices:
            still[i] = 0.0
    return model.project(np.clip(still, *problem.bounds.T))


def _reached(problem: PlanningTask, guess: Array) -> Array:
    """Return the state of a configuration solved for the goal, with closed loops, shape (nx,)."""
    from scipy.optimize import least_squares

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
        max_nfev=200,  # evaluations per inverse-kinematics search
    )
    return state(found.x)
