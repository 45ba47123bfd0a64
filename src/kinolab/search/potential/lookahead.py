"""Lookahead: candidate inputs, simulated to a horizon and ranked by the potential they reach.

A force on a crane's load has no immediate effect on its trolley, nor a lateral force on a car's
steering: the response comes only later. So inputs are also chosen by linear least squares on the
positions of the control points at the horizon.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinolab.concurrency.cancel import CancellationToken, never_cancelled, raise_if_cancelled
from kinolab.errors import KinolabError
from kinolab.numerics.arrays import Array
from kinolab.numerics.bounded_lsq import bounded_least_squares
from kinolab.search.potential.field import Field
from kinolab.search.potential.pullback import InputProjection, independent_entries
from kinolab.simulation import ZeroOrderHold

FD_STEP = 0.05  # finite difference, of an input's range


class Lookahead:
    """Proposes inputs for a state.

    Args:
        projection: Maps its forces to inputs.
        steps: Horizon in time steps of the problem.
        draws: Number of additional random proposals.
        stop: Cancellation token; cancelling raises a CancelledError.
    """

    def __init__(
        self,
        field: Field,
        projection: InputProjection,
        steps: int,
        draws: int,
        stop: CancellationToken = never_cancelled,
    ) -> None:
        self._field, self._projection, self._stop = field, projection, stop
        self.steps, self._draws = steps, draws
        self._rollout = ZeroOrderHold(field.problem)
        self._lower, self._upper = field.problem.model.control_bounds.T

    def proposals(self, x: Array, u: Array, generator: np.random.Generator) -> list[Array]:
        """Return inputs (nu,) for a state, the best first, without those whose simulation fails.

        Args:
            x: State, shape (nx,).
            u: Current inputs, shape (nu,).
        """
        found, ends = [], []
        for proposed in self._ideas(x, u, generator):
            raise_if_cancelled(self._stop)
            end = self._rollout.end(x, proposed, self.steps)
            if end is not None:
                found.append(proposed)
                ends.append(end)
        if not found:
            return []
        values = self._field.potential(np.array(ends))
        return [found[k] for _, k in sorted(zip(values.tolist(), range(len(found)), strict=True))]

    def _ideas(self, x: Array, u: Array, generator: np.random.Generator) -> Iterator[Array]:
        yield u
        yield from self._pulled_back(x)
        yield from self._by_linear_response(x, u)
        for k in range(self._draws):
            drawn = generator.uniform(self._lower, self._upper)
            # Half of them lie near the current inputs, to refine a good choice.
            yield drawn if k % 2 else np.clip(u + 0.2 * (drawn - u), self._lower, self._upper)

    def _pulled_back(self, x: Array) -> Iterator[Array]:
        try:
            yield self._projection.inputs(x, self._field.forces(x), len(self._field.pulls))
        except KinolabError:
            return  # kinematic, or singular here: the other proposals remain

    def _by_linear_response(self, x: Array, u: Array) -> Iterator[Array]:
        """Yield inputs that move the control points down the field, and one that brakes."""
        base = self._rollout.end(x, u, self.steps)
        nudges = np.where(u > (self._lower + self._upper) / 2, -FD_STEP, FD_STEP)
        nudges *= self._upper - self._lower
        ends = []
        for step in np.diag(nudges):
            raise_if_cancelled(self._stop)
            ends.append(self._rollout.end(x, u + step, self.steps))
        if base is None or any(end is None for end in ends):
            return
        states = np.array([base, *ends])
        bounds = self._lower - u, self._upper - u
        points = self._field.points(np.vstack([states, x]))
        response = ((points[1:-1] - points[0]).reshape(len(u), -1) / nudges[:, None]).T
        path = self._way_down(points[-1])
        weights = np.repeat(np.sqrt([pull.weight for pull in self._field.pulls]), 3)
        # [m] targets for the control points' motion within the horizon
        for stride in (0.3, 1.0, 3.0) if len(path) else ():
            short = points[-1] + stride * path - points[0]
            target = weights * short.reshape(-1)
            yield u + bounded_least_squares(weights[:, None] * response, target, *bounds)
        entries = independent_entries(self._field.problem.model)
        scales = self._field.problem.scales[entries]
        slowing = ((states[1:, entries] - base[entries]) / nudges[:, None] / scales).T
        if slowing.size:
            yield u + bounded_least_squares(slowing, -base[entries] / scales, *bounds)

    def _way_down(self, points: Array) -> Array:
        """Return descent directions of the control points (n, 3), of norm at most 1, (n, 3)."""
        found = []
        for pull, at in zip(self._field.pulls, points, strict=True):
            value, slope = pull.potential(at[None])
            length = float(np.linalg.norm(slope))
            found.append(-slope[0] / max(length, 1e-12) * min(1.0, float(value[0])))
        return np.array(found).reshape(-1, 3)
