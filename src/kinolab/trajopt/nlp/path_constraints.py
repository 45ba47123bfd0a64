"""Path constraints: inequalities on state and inputs along a trajectory, linearised at samples.

They are requirements, guards of transitions that do not take place, limits of dependent rates,
workspace bounds and keep-out cones. They can only be evaluated, so derivatives are central
differences.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.numerics.columnar import Columns
from kinolab.problem import PlanningTask
from kinolab.trajopt.nlp.decision import ONE_PHASE, Knots
from kinolab.trajopt.nlp.options import NLP


class PathConstraints:
    """Margins of all path constraints.

    Args:
        clearance: Scaled amount by which each margin is tightened.
        begins: Whether to evaluate where steps begin. There inputs jump, and margins that depend on
            them; all others equal those at the end of the previous step and are left out.
    """

    def __init__(self, problem: PlanningTask, clearance: float, *, begins: bool = False) -> None:
        self._problem, self.begins = problem, begins
        self._clearance: float | Array = clearance
        self._decided = _decided_by_inputs(problem) if begins else np.zeros(0, dtype=bool)
        self._steps = variable_scales(problem)
        self._rates = [
            k for k, limits in enumerate(problem.rate_bounds) if np.isfinite(limits).any()
        ]
        machine = problem.machine
        anything = machine.requirements or machine.modes or self._rates or problem.world.bounds
        self._any = bool(self._decided.any() if begins else anything or problem.keep_outs)

    def tightened(self, excess: Array) -> PathConstraints:
        """Return the same with each margin tightened by some more, scaled, shape (constraints,)."""
        other = copy.copy(self)
        other._clearance = self._clearance + excess
        return other

    def margins(self, x: Array, u: Array, switching: NDArray[np.bool_] | bool = False) -> Array:
        """Return all margins at states (m, nx) and inputs (m, nu), shape (m, constraints).

        Args:
            switching: Where they are not tightened, shape (m,): at a transition a guard is zero.
        """
        parts = [part.reshape(len(x), -1) for part in self._parts(x, u)]
        reserve = np.where(np.reshape(switching, (-1, 1)), 0.0, self._clearance)
        return np.hstack([np.zeros((len(x), 0)), *parts]) - reserve

    def violation(self, at: Samples) -> float:
        """Return the sum of all violations at samples."""
        return float(np.maximum(-self.margins(at.x, at.u, at.switching), 0.0).sum())

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
        value, large = self.margins(at.x, at.u, at.switching), np.concatenate(self._steps)
        slopes = central_differences(
            lambda z: self.margins(z[:, :nx], z[:, nx:]), np.hstack([at.x, at.u]), large
        )
        change = np.abs(slopes) @ large * reach
        which, kind = np.nonzero(value < 2 * change)
        slope = slopes[which, kind]
        return at.rows(which, value[which, kind], slope[:, :nx], slope[:, nx:])

    def _parts(self, x: Array, u: Array) -> Iterator[Array]:
        problem, model = self._problem, self._problem.model
        if self.begins:
            if self._any:
                yield _requirements(problem, x, u)[:, self._decided]
            return
        yield _requirements(problem, x, u)
        if self._rates:
            rates = model.velocity(x, u)[:, self._rates]
            lower, upper = problem.rate_bounds[self._rates].T
            both = np.concatenate([rates - lower, upper - rates], axis=1)
            large = np.concatenate([upper - lower] * 2) / 2
            finite = np.isfinite(both).all(axis=0)
            yield both[:, finite] / np.where(np.isfinite(large), large, 1.0)[finite]
        if problem.world.bounds or problem.keep_outs:
            yield problem.pose_margins(model.frames(x))


def _requirements(problem: PlanningTask, x: Array, u: Array) -> Array:
    """Return margins of requirements, and of guards: that no transition takes place, (m, n)."""
    model, margins = problem.model, np.zeros((len(x), 0))
    if problem.machine.requirements:
        margins = model.requirements(x, u)
    if not problem.machine.modes:
        return margins
    guard, _, condition = np.moveaxis(model.guards(x, u), -1, 0)
    held_off = np.where(condition > 0, guard, np.maximum(guard, -condition))
    return np.hstack([margins, held_off])


def _decided_by_inputs(problem: PlanningTask) -> NDArray[np.bool_]:
    """Say which requirements depend on the inputs, tested at random states, shape (m,)."""
    if not (problem.machine.requirements or problem.machine.modes):
        return np.zeros(0, dtype=bool)
    random, half = np.random.default_rng(0), _half_ranges(problem)
    x = np.array([problem.start, *(problem.sample_goal(random) for _ in range(NLP.random_states))])
    some = [random.uniform(-half, half, (len(x), len(half))) for _ in range(2)]
    decided = []
    for mode in range(max(len(problem.machine.modes), 1)):
        if problem.machine.modes:
            x[:, -1] = mode
        one, other = (_requirements(problem, x, u) for u in some)
        decided.append((np.abs(one - other) > 0).any(axis=0))
    return np.asarray(np.any(decided, axis=0))


def variable_scales(problem: PlanningTask) -> tuple[Array, Array]:
    """Return scales of states (nx,) and inputs (nu,); 0 for the mode, which does not vary."""
    scales = problem.scales.copy()
    if problem.machine.modes:
        scales[-1] = 0.0
    return scales, _half_ranges(problem)


def central_differences(function: Callable[[Array], Array], z: Array, scales: Array) -> Array:
    """Return derivatives of a function of rows by the variables that vary, (m, n, variables).

    Args:
        function: From rows (k, variables) to values (k, n).
        z: Where, shape (m, variables).
        scales: Of the variables, shape (variables,); derivatives by those of scale 0 are 0.
    """
    steps = NLP.scaled_fd_step * scales
    varied = np.flatnonzero(steps)
    # 20_000 states at which margins are evaluated in one call: some 10 MB of poses
    at_once, slopes = max(1, 20_000 // (2 * max(len(z), 1))), []
    for first in range(0, len(varied), at_once):
        shift = np.diag(steps)[varied[first : first + at_once], None]
        moved = np.stack([z + shift, z - shift])
        values = function(moved.reshape(-1, z.shape[1])).reshape(*moved.shape[:3], -1)
        slopes.append((values[0] - values[1]) / (2 * shift.max(axis=2)[..., None]))
    found = np.concatenate(slopes)
    out = np.zeros((len(scales), *found.shape[1:]))
    out[varied] = found
    return np.moveaxis(out, 0, -1)


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
        switching: Which of them are in a step before or after a transition, shape (m,), or none.
    """

    knot: NDArray[np.int64]
    share: Array
    x: Array
    u: Array
    switching: NDArray[np.bool_] | bool = False

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


def samples(knots: Knots, pieces: int, entered: Array | None = None) -> Samples:
    """Sample ``pieces`` evenly spaced states per step, excluding the start.

    Args:
        pieces: Samples per step.
        entered: From where steps are smooth, shape (N, nx); the knots where left out.
    """
    steps = len(knots.u)
    knot, begin = np.repeat(np.arange(steps), pieces), knots.x[:-1] if entered is None else entered
    fraction = np.tile(np.arange(1, pieces + 1) / pieces, steps)
    x = begin[knot] * (1 - fraction)[:, None] + knots.x[1:][knot] * fraction[:, None]
    if knots.phases is not ONE_PHASE:
        x[:, -1] = begin[knot, -1]  # not but for rounding
    switching = np.isin(knot, knots.phases.begins) | np.isin(knot + 1, knots.phases.begins)
    return Samples(knot, fraction, x, knots.u[knot], switching)


def beginnings(knots: Knots, entered: Array | None = None) -> Samples:
    """Return the state at the beginning of each step with the inputs of that step.

    Args:
        entered: As in ``samples``, shape (N, nx).
    """
    knot = np.arange(len(knots.u))
    x, switching = knots.x[:-1] if entered is None else entered, np.isin(knot, knots.phases.begins)
    return Samples(knot, np.zeros(len(knot)), x, knots.u, switching)


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
