"""Goal constraint at the final state: every target met exactly, not within its tolerance."""

from __future__ import annotations

import numpy as np

from kinolab.dynamics.codegen.state_space import whole_turns
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.trajopt.nlp.options import SHORT


class GoalConstraint:
    """Goal equations on the branch nearest to a guess.

    Circular angles meet their target once per turn and attitudes have two quaternions: the branch
    nearest to the guess is fixed, which keeps the equations smooth.

    Args:
        guess: Guess of the final state, shape (nx,).
    """

    def __init__(self, problem: PlanningTask, guess: Array) -> None:
        self._problem, goal = problem, problem.goal
        entries = list(goal.indices)
        turns = whole_turns(guess[entries] - goal.targets)
        targets = goal.targets + np.where(goal.circular, turns, 0.0)
        parts = [one.part.nearest(guess[one.part.own], np.array(one.target)) for one in goal.parts]
        self._entries, self._targets = goal.entries, np.concatenate([targets, *parts])
        self._large = problem.scales[goal.entries]

    def residual(self, x: Array) -> Array:
        """Goal residual at the final state, scaled; shape (ng,)."""
        near: Array = (x[self._entries] - self._targets) / self._large
        goal = self._problem.goal
        if not goal.needs_frames:
            return near
        frames = self._problem.frames(x)
        return np.concatenate([near, *(target.offset(frames) for target in goal.of_bodies)])

    def jacobian(self, x: Array) -> Array:
        """Jacobian of ``residual``, shape (ng, nx)."""
        nx, goal = len(x), self._problem.goal
        own = np.zeros((len(self._entries), nx))
        own[np.arange(len(self._entries)), self._entries] = 1 / self._large
        if not goal.needs_frames:
            return own
        columns = np.moveaxis(self._problem.model.frames_jacobian(x), -1, 0)
        return np.vstack([own, *(target.in_world(columns).T for target in goal.of_bodies)])


def meets_centre(problem: PlanningTask, x: Array) -> bool:
    """Say whether a final state, shape (nx,), lies in the goal's centre."""
    return bool(np.abs(GoalConstraint(problem, x).residual(x)).sum() <= SHORT.centre_tolerance)
