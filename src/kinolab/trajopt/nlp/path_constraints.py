"""Path constraints: inequalities on state and inputs along a trajectory, linearised at samples.

They are requirements, limits of dependent rates, workspace bounds and keep-out cones. They can only
be evaluated, so derivatives are central differences.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.numerics.columnar import Columns
from kinolab.problem import PlanningTask
from kinolab.trajopt.nlp.decision import Knots
from kinolab.trajopt.options import NLP

ROWS_AT_ONCE = 20_000  # states at which margins are evaluated in one call: some 10 MB of poses


class PathConstraints:
    """Margins of all path constraints.

    Args:
        problem: The planning problem.
        clearance: Scaled amount by which each margin is tightened.
        begins: Whether to evaluate where steps begin. There inputs jump, and margins that depend on
            them; all others equal those at the end of the previous step and are left out.
    """

    def __init__(self, problem: PlanningTask, clearance: float, *, begins: bool = False) -> None:
        self._problem, self.begins = problem, begins
        self._clearance: float | Array = clearance
        self._decided = _decided_by_inputs(problem) if begins else np.zeros(0, dtype=bool)
        self._steps = (problem.scales, _half_ranges(problem))
        self._rates = [
            k for k, limits in enumerate(problem.rate_bounds) if np.isfinite(limits).any()
        ]
        anything = problem.machine.requirements or self._rates or problem.world.bounds
        self._any = bool(self._decided.any() if begins else anything or problem.keep_outs)

    def tightened(self, excess: Array) -> PathConstraints:
        """Return the same with each margin tightened by some more, scaled, shape (constraints,)."""
        other = copy.copy(self)
        other._clearance = self._clearance + excess
        return other

    def margins(self, x: Array, u: Array) -> Array:
        """Return all margins at states (m, nx) and inputs (m, nu), shape (m, constraints)."""
        parts = [part.reshape(len(x), -1) for part in self._parts(x, u)]
        return np.hstack([np.zeros((len(x), 0)), *parts]) - self._clearance

    def violation(self, at: Samples) -> float:
        """Return the sum of all violations at samples."""
        return float(np.maximum(-self.margins(at.x, at.u), 0.0).sum())

    def rows(self, at: Samples, reach: float) -> LinearInequalities:
        """Linearise the margins that a step may violate.

        Args:
            at: Samples to evaluate at.
            reach: Largest scaled change of any variable.
        """
        nx, nu = at.x.shape[1], at.u.shape[1]
        if not self._any:
            none = np.zeros(0, np.int64)
            return at.rows(none, np.zeros(0), np.zeros((0, nx)), np.zeros((0, nu)))
        value = self.margins(at.x, at.u)
        large = np.concatenate(self._steps)
        slopes = self._slopes(np.hstack([at.x, at.u]), NLP.scaled_fd_step * large, nx)
        change = np.abs(slopes) @ large * reach
        which, kind = np.nonzero(value < 2 * change)
        slope = slopes[which, kind]
        return at.rows(which, value[which, kind], slope[:, :nx], slope[:, nx:])

    def _slopes(self, z: Array, steps: Array, nx: int) -> Array:
        """Return the derivatives of all margins, shape (m, constraints, nx + nu).

        Args:
            z: States and inputs, shape (m, nx + nu).
            steps: Finite differences, shape (nx + nu,).
            nx: Number of state entries.
        """
        at_once = max(1, ROWS_AT_ONCE // (2 * max(len(z), 1)))
        slopes = []
        for first in range(0, len(steps), at_once):
            shift = np.diag(steps)[first : first + at_once, None]
            moved = np.stack([z + shift, z - shift])
            rows = moved.reshape(-1, z.shape[1])
            margins = self.margins(rows[:, :nx], rows[:, nx:]).reshape(*moved.shape[:3], -1)
            slopes.append((margins[0] - margins[1]) / (2 * shift.max(axis=2)[..., None]))
        return np.moveaxis(np.concatenate(slopes), 0, -1)

    def _parts(self, x: Array, u: Array) -> Iterator[Array]:
        problem, model = self._problem, self._problem.model
        if self.begins:
            if self._any:
                yield model.requirements(x, u)[:, self._decided]
            return
        if problem.machine.requirements:
            yield model.requirements(x, u)
        if self._rates:
            rates = model.velocity(x, u)[:, self._rates]
            lower, upper = problem.rate_bounds[self._rates].T
            both = np.concatenate([rates - lower, upper - rates], axis=1)
            large = np.concatenate([upper - lower] * 2) / 2
            finite = np.isfinite(both).all(axis=0)
            yield both[:, finite] / np.where(np.isfinite(large), large, 1.0)[finite]
        if problem.world.bounds or problem.keep_outs:
            yield problem.pose_margins(model.frames(x))


def _decided_by_inputs(problem: PlanningTask) -> NDArray[np.bool_]:
    """Say which requirements depend on the inputs, tested at random states, shape (m,)."""
    if not problem.machine.requirements:
        return np.zeros(0, dtype=bool)
    random, half = np.random.default_rng(0), _half_ranges(problem)
    x = np.array([problem.start, *(problem.sample_goal(random) for _ in range(NLP.random_states))])
    some = (random.uniform(-half, half, (len(x), len(half))) for _ in range(2))
    one, other = (problem.model.requirements(x, u) for u in some)
    return np.asarray((np.abs(one - other) > 0).any(axis=0))


def _half_ranges(problem: PlanningTask) -> Array:
    lower, upper = problem.model.control_bounds.T
    half = (upper - lower) / 2
    return np.where(np.isfinite(half), half, 1.0)


@dataclass(frozen=True, eq=False)
class Samples:
    """States on the straight lines between knots.

    Attributes:
        knot: Index of the preceding knot, shape (m,).
        share: Fraction of the step to the next knot, in [0, 1], shape (m,).
        x: States, shape (m, nx).
        u: Inputs, shape (m, nu).
    """

    knot: NDArray[np.int64]
    share: Array
    x: Array
    u: Array

    def rows(
        self, which: NDArray[np.int64], value: Array, dx: Array, du: Array
    ) -> LinearInequalities:
        """Return inequalities on the knots from derivatives at samples.

        Args:
            which: Sample index of each inequality, shape (n,).
            value: Margins, shape (n,).
            dx: Derivative with respect to the sample's state, shape (n, nx).
            du: With respect to its inputs, shape (n, nu).
        """
        fraction = self.share[which][:, None]
        return LinearInequalities(self.knot[which], value, (1 - fraction) * dx, fraction * dx, du)


def samples(knots: Knots, pieces: int) -> Samples:
    """Sample ``pieces`` evenly spaced states per step, excluding the start."""
    steps = len(knots.u)
    knot = np.repeat(np.arange(steps), pieces)
    fraction = np.tile(np.arange(1, pieces + 1) / pieces, steps)
    x = knots.x[:-1][knot] * (1 - fraction)[:, None] + knots.x[1:][knot] * fraction[:, None]
    return Samples(knot, fraction, x, knots.u[knot])


def beginnings(knots: Knots) -> Samples:
    """Return the state at the beginning of each step with the inputs of that step."""
    steps = len(knots.u)
    return Samples(np.arange(steps), np.zeros(steps), knots.x[:-1], knots.u)


@dataclass(frozen=True, eq=False)
class LinearInequalities(Columns):
    """Linearised inequalities, margin >= 0, each at a knot or between it and the next.

    Attributes:
        knot: Knot index, shape (m,).
        value: Scaled margin, shape (m,).
        dx: Derivative with respect to the knot's state, shape (m, nx).
        dx_next: With respect to the next knot's state, shape (m, nx).
        du: With respect to the inputs of that step, shape (m, nu).
    """

    knot: NDArray[np.int64]
    value: Array
    dx: Array
    dx_next: Array
    du: Array

    @property
    def violation(self) -> float:
        """Sum of all violations."""
        return float(np.maximum(-self.value, 0.0).sum())
