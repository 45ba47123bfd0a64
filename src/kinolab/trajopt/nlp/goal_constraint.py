"""What is missing at the end of a trajectory: every target exactly, not within its tolerance."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.state_space import whole_turns
from kinolab.problem import Problem
from kinolab.trajopt.options import NLP

Array: TypeAlias = NDArray[np.float64]


class GoalConstraint:
    """The equations of the goal near one way to reach it.

    Angles on the circle have their target once per turn and attitudes have two quaternions: the
    ones nearest to a first guess are kept, so that the equations are smooth.

    Args:
        problem: With the goal.
        guess: Where the trajectory ends so far, shape (nx,).
    """

    def __init__(self, problem: Problem, guess: Array) -> None:
        self._problem, goal = problem, problem.goal
        entries = list(goal.indices)
        turns = whole_turns(guess[entries] - goal.targets)
        targets = goal.targets + np.where(goal.circular, turns, 0.0)
        for attitude in goal.attitudes:
            own, target = attitude.entries, np.array(attitude.target)
            entries += range(own.start, own.stop)
            nearer = target if guess[own] @ target >= 0 else -target
            targets = np.concatenate([targets, nearer])
        self._entries, self._targets = entries, targets
        self._large = problem.scales[entries]

    def residual(self, x: Array) -> Array:
        """Return what is missing at a last state, as shares of what counts as large."""
        near = (x[self._entries] - self._targets) / self._large
        return np.concatenate([near, *self._of_bodies(x)])

    def jacobian(self, x: Array) -> Array:
        """Return the derivative of ``residual``, shape (m, nx)."""
        nx, goal = len(x), self._problem.goal
        own = np.zeros((len(self._entries), nx))
        own[np.arange(len(self._entries)), self._entries] = 1 / self._large
        if not goal.needs_frames:
            return own
        columns = [
            (np.concatenate([*self._of_bodies(x + d)]) - np.concatenate([*self._of_bodies(x - d)]))
            / (2 * NLP.fd_step)
            for d in NLP.fd_step * np.eye(nx)
        ]
        return np.vstack([own, np.column_stack(columns)])

    def _of_bodies(self, x: Array) -> Iterator[Array]:
        goal = self._problem.goal
        if not goal.needs_frames:
            return
        frames = self._problem.frames(x).reshape(-1, 3, 4)
        for point in goal.points:
            pose = frames[point.body]
            yield pose[:, :3] @ np.asarray(point.at) + pose[:, 3] - np.asarray(point.position)
        for axis in goal.directions:
            yield frames[axis.body][:, :3] @ np.asarray(axis.axis) - np.asarray(axis.target)
