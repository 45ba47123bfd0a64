"""What a machine and its world demand of every state, beside limits of the state itself.

These are requirements, limits of dependent rates, the limits of the workspace and cones that axes
keep out of: functions of state and inputs that come as numbers, so that central differences have
to do for their derivatives.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.problem import Problem
from kinolab.trajopt.nlp.linear_inequalities import LinearInequalities, no_inequalities
from kinolab.trajopt.nlp.samples import Samples
from kinolab.trajopt.options import NLP

Array: TypeAlias = NDArray[np.float64]


class PathConstraints:
    """The margins of all demands.

    Args:
        problem: Whose machine and world.
        clearance: Share of what counts as large that each margin keeps in reserve.
        begins: Whether it is looked at where steps begin. There inputs jump, and what they decide
            with them; all else is what it was at the end of the step before, and left out.
    """

    def __init__(self, problem: Problem, clearance: float, *, begins: bool = False) -> None:
        self._problem, self._room, self.begins = problem, clearance, begins
        self._decided = _decided_by_inputs(problem) if begins else np.zeros(0, dtype=bool)
        self._steps = (problem.scales, _half_ranges(problem))
        self._rates = [
            k for k, limits in enumerate(problem.rate_bounds) if np.isfinite(limits).any()
        ]
        anything = problem.system.requirements or self._rates or problem.world.bounds
        self._any = bool(self._decided.any() if begins else anything or problem.keep_outs)

    def margins(self, x: Array, u: Array) -> Array:
        """Return all margins at states (m, nx) under inputs (m, nu), shape (m, demands)."""
        parts = [part.reshape(len(x), -1) for part in self._parts(x, u)]
        return np.hstack([np.zeros((len(x), 0)), *parts]) - self._room

    def violation(self, at: Samples) -> float:
        """Return the sum of all that is missing at samples."""
        if not self._any:
            return 0.0
        return float(np.maximum(-self.margins(at.x, at.u), 0.0).sum())

    def rows(self, at: Samples, reach: float) -> LinearInequalities:
        """Return the margins that a change may use up.

        Args:
            at: Where to look.
            reach: Largest change of any variable, as a share of what counts as large.
        """
        nx, nu = at.x.shape[1], at.u.shape[1]
        if not self._any:
            return no_inequalities(nx, nu)
        value = self.margins(at.x, at.u)
        slopes = np.zeros((*value.shape, nx + nu))
        change = np.zeros(value.shape)
        for j, large in enumerate(np.concatenate(self._steps)):
            d = np.zeros(nx + nu)
            d[j] = NLP.scaled_fd_step * large
            ahead = self.margins(at.x + d[:nx], at.u + d[nx:])
            behind = self.margins(at.x - d[:nx], at.u - d[nx:])
            slopes[..., j] = (ahead - behind) / (2 * NLP.scaled_fd_step * large)
            change += np.abs(slopes[..., j]) * large * reach
        which, kind = np.nonzero(value < 2 * change)
        slope = slopes[which, kind]
        return at.rows(which, value[which, kind], slope[:, :nx], slope[:, nx:])

    def _parts(self, x: Array, u: Array) -> Iterator[Array]:
        problem, model = self._problem, self._problem.model
        if self.begins:
            if self._any:
                yield model.requirements(x, u)[:, self._decided]
            return
        if problem.system.requirements:
            yield model.requirements(x, u)
        if self._rates:
            rates = model.velocity(x, u)[:, self._rates]
            lower, upper = problem.rate_bounds[self._rates].T
            both = np.concatenate([rates - lower, upper - rates], axis=1)
            large = np.concatenate([upper - lower] * 2) / 2
            finite = np.isfinite(both).all(axis=0)
            yield both[:, finite] / np.where(np.isfinite(large), large, 1.0)[finite]
        if problem.world.bounds or problem.keep_outs:
            yield from self._of_bodies(model.frames(x).reshape(len(x), -1, 3, 4))

    def _of_bodies(self, frames: Array) -> Iterator[Array]:
        for axis, (lower, upper) in self._problem.world.bounds.items():
            place = frames[:, :, "xyz".index(axis), 3]
            yield from (place - lower, upper - place)
        for cone in self._problem.keep_outs:
            axis = frames[:, cone.body, :, :3] @ np.asarray(cone.axis)
            yield np.cos(cone.half_angle) - axis @ np.asarray(cone.direction)


def _decided_by_inputs(problem: Problem) -> NDArray[np.bool_]:
    """Return which requirements depend on the inputs, as states at random show, shape (m,)."""
    if not problem.system.requirements:
        return np.zeros(0, dtype=bool)
    random, half = np.random.default_rng(0), _half_ranges(problem)
    x = np.array([problem.start, *(problem.sample_goal(random) for _ in range(NLP.random_states))])
    some = (random.uniform(-half, half, (len(x), len(half))) for _ in range(2))
    one, other = (problem.model.requirements(x, u) for u in some)
    return np.asarray((np.abs(one - other) > 0).any(axis=0))


def _half_ranges(problem: Problem) -> Array:
    lower, upper = problem.model.control_bounds.T
    half = (upper - lower) / 2
    return np.where(np.isfinite(half), half, 1.0)
