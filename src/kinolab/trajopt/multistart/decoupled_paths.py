"""Collision-free paths along a machine's decoupling vector fields, one field at a time: an RRT.

Each branch follows every field once, in random order and for random lengths. The end of a path is
moved into the goal's centre by changing its last lengths (Gauss-Newton).

Source: LaValle, Kuffner, Randomized kinodynamic planning, IJRR 20(5), 2001; Bullo, Lynch, Kinematic
controllability for decoupled trajectory planning, IEEE Trans. Robotics and Automation 17(4), 2001.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinolab.concurrency.cancel import raise_if_cancelled
from kinolab.dynamics import Model
from kinolab.errors import SingularError
from kinolab.numerics.arrays import Array
from kinolab.numerics.work import charge
from kinolab.problem import PlanningTask
from kinolab.trajopt.multistart.allowed_velocities import velocity_directions
from kinolab.trajopt.multistart.geometric_path import GeometricPaths
from kinolab.trajopt.options import FIELDS


@dataclass(frozen=True)
class Leg:
    """A piece of a path: one field, followed for a signed length."""

    field: int
    length: float


class DecoupledPaths:
    """Paths along decoupling fields for one machine in one world.

    Args:
        problem: The planning problem.
        reduction: The machine that follows the fields, by ``decoupled_model``.
        generator: Random number generator.
        cancelled: Whether to give up, with a CancelledError.
    """

    def __init__(
        self,
        problem: PlanningTask,
        reduction: Model,
        generator: np.random.Generator,
        cancelled: Callable[[], bool],
    ) -> None:
        self._problem, self._reduction, self._generator = problem, reduction, generator
        self._cancelled, self._nq = cancelled, problem.model.nq
        self._free = GeometricPaths(problem, generator, cancelled)
        self._weights = problem.weights.copy()
        self._weights[self._nq :] = 0.0
        self._longest, self._slowness = self._longest_legs(), self._durations()

    def find(self) -> list[Leg] | None:
        """Return legs from the start to the goal's centre; None if a tree does not get there.

        Raises:
            CancelledError: If cancelled.
        """
        tree = _FieldTree(self._problem.start[: self._nq])
        best, tried = np.inf, 0
        for k in range(FIELDS.max_branches):
            raise_if_cancelled(self._cancelled)
            aims = k % FIELDS.goal_period == 0
            leaf = self._grown(tree, *self._drawn(to_goal=aims))
            if leaf is None:
                continue
            excess = self._problem.goal_excess(self._still(tree.q[leaf]))
            if excess < best or (aims and excess < FIELDS.near * best):
                tried, best = tried + 1, min(best, excess)
                legs = self._ended(tree.legs(leaf))
                if legs is not None:
                    return legs
        return None

    def configurations(self, q: Array, leg: Leg) -> Array:
        """Return configurations (samples + 1, nq) along a leg that begins at q."""
        followed: Array = self._followed(q[None], leg.field, np.array([leg.length]))[0]
        return followed

    def _still(self, q: Array) -> Array:
        """Return states (..., nx) at rest."""
        still = np.zeros((*q.shape[:-1], self._problem.model.nv))
        return np.concatenate([q, still], axis=-1)

    def _longest_legs(self) -> Array:
        """Return how far each field may be followed at most, shape (fields,).

        As far as start and goal are apart, in the planner's metric, but over no limit's range.
        """
        problem, model = self._problem, self._reduction
        generator = np.random.default_rng(0)
        places = np.array([problem.sample(generator) for _ in range(FIELDS.speed_samples)])
        aims = np.array([problem.sample_goal(generator) for _ in range(FIELDS.speed_samples)])
        goal = self._goal_weights()
        apart = problem.space.distance(problem.start, aims, goal).min() + FIELDS.least_reach
        ranges = np.ptp(problem.bounds[: self._nq], axis=1)
        longest = []
        for field in range(model.nu):
            rates = self.rates(places[:, : self._nq], field)
            speed = np.linalg.norm(rates * self._weights[: self._nq], axis=1)
            with np.errstate(divide="ignore"):
                within = (ranges / np.abs(rates).max(axis=0)).min()
                longest.append(min(apart / np.median(speed), within))
        return np.array(longest)

    def _durations(self) -> Array:
        """Return about how long a unit of each field takes at the limits of velocities, in [s]."""
        problem, generator = self._problem, np.random.default_rng(0)
        places = np.array([problem.sample(generator) for _ in range(FIELDS.speed_samples)])
        directions = velocity_directions(problem, places, np.arange(self._nq))
        limits = np.abs(problem.bounds[self._nq :]).min(axis=1)
        taken = []
        for field in range(self._reduction.nu):
            rates = self.rates(places[:, : self._nq], field)
            speeds = np.abs((np.linalg.pinv(directions) @ rates[..., None])[..., 0]) / limits
            taken.append(np.median(speeds.max(axis=1)))
        return np.array(taken)

    def _times(self, lengths: Array, order: NDArray[np.int64]) -> Array:
        """Estimate the time in [s] until each sample of branches' last legs, (m, samples + 1)."""
        taken = np.abs(lengths) * self._slowness + FIELDS.stop
        share = np.linspace(0.0, 1.0, FIELDS.samples + 1)
        before = taken[:, order[:-1]].sum(axis=1)[:, None]
        times: Array = before + FIELDS.stop + (taken[:, order[-1:]] - FIELDS.stop) * share
        return times

    def rates(self, q: Array, field: int) -> Array:
        """Return the rates of coordinates (m, nq) at configurations along a field."""
        model = self._reduction
        x = np.hstack([q, np.zeros((len(q), model.nx - self._nq))])
        rates: Array = model.f(x, np.tile(np.eye(model.nu)[field], (len(q), 1)))[:, : self._nq]
        return rates

    def _goal_weights(self) -> Array:
        """Return the metric's weights (nx,) without what the goal leaves free."""
        goal = self._problem.goal
        if goal.points or goal.attitudes or goal.needs_frames:
            return self._weights
        kept = np.zeros(len(self._weights))
        kept[list(goal.indices)] = self._weights[list(goal.indices)]
        return kept

    def _drawn(self, *, to_goal: bool) -> tuple[Array, Array]:
        """Return a state (nx,) to grow to, and the metric's weights (nx,) that count there."""
        if to_goal:
            return self._problem.sample_goal(self._generator, 0.0), self._goal_weights()
        return self._problem.sample(self._generator), self._weights

    def _grown(self, tree: _FieldTree, aim: Array, weights: Array) -> int | None:
        """Grow the nearest leaf towards a state; return the new leaf, None if nothing gets nearer.

        Of several branches, the one that gets nearer fastest is taken if it is free.
        """
        space, count = self._problem.space, self._reduction.nu
        apart = space.distance(self._still(tree.q), aim, weights)
        parent = int(apart.argmin())
        order = self._generator.permutation(count)
        lengths = self._random_lengths((FIELDS.candidates, count))
        q = np.repeat(tree.q[parent][None], len(lengths), axis=0)
        inside = np.ones((len(lengths), 1), dtype=bool)
        pieces = []
        for field in order.tolist():
            piece = self._followed(q, field, lengths[:, field])
            inside = self._within_limits(piece) & inside[:, -1:]
            pieces.append(piece)
            q = np.where(inside[:, -1:], piece[:, -1], q)
        ends = space.distance(self._still(pieces[-1]), aim, weights)
        ends = np.where(inside, ends, np.inf)
        charge(FIELDS.cost)
        gains = (apart[parent] - ends) / self._times(lengths, order)
        for row in np.argsort(-gains.max(axis=1))[: FIELDS.checked].tolist():
            last = int(gains[row].argmax())
            if not gains[row, last] > 0:
                return None
            way = [piece[row] for piece in pieces[:-1]] + [pieces[-1][row, : last + 1]]
            if self._is_free(way):
                legs = [Leg(field, float(lengths[row, field])) for field in order.tolist()]
                share = last / FIELDS.samples
                legs[-1] = Leg(legs[-1].field, legs[-1].length * share)
                return tree.add(way[-1][-1], parent, [leg for leg in legs if leg.length])
        return None

    def _random_lengths(self, shape: tuple[int, int]) -> Array:
        """Return signed lengths (m, fields): of all magnitudes alike."""
        generator = self._generator
        sizes = np.exp(generator.uniform(np.log(FIELDS.shortest), 0.0, shape))
        lengths: Array = generator.choice([-1.0, 1.0], shape) * sizes * self._longest
        return lengths

    def _followed(self, q: Array, field: int, lengths: Array) -> Array:
        """Follow a field from configurations (m, nq), (m, samples + 1, nq); NaN where it ends."""
        model, count = self._reduction, FIELDS.samples
        x = np.hstack([q, np.zeros((len(q), model.nx - self._nq))])
        u = np.sign(lengths)[:, None] * np.eye(model.nu)[field]
        spans = np.abs(lengths) / count
        out = np.full((len(q), count + 1, self._nq), np.nan)
        out[:, 0] = q
        alive: NDArray[np.bool_] = np.asarray(np.isfinite(q).all(axis=1))
        for k in range(1, count + 1):
            while alive.any():
                rows = np.flatnonzero(alive)
                try:
                    x[rows] = model.step(x[rows], u[rows], spans[rows])
                    break
                except SingularError as error:
                    alive[rows[error.row or 0]] = False
            out[alive, k] = x[alive, : self._nq]
        return out

    def _within_limits(self, pieces: Array) -> NDArray[np.bool_]:
        """Return which samples (m, n, nq) are reached within limits, shape (m, n)."""
        flat = pieces.reshape(-1, self._nq)
        finite = np.isfinite(flat).all(axis=1)
        fine = np.zeros(len(flat), dtype=bool)
        fine[finite] = ~self._problem.outside_limits(self._still(flat[finite]))
        within: NDArray[np.bool_] = np.logical_and.accumulate(
            fine.reshape(pieces.shape[:2]), axis=1
        )
        return within

    def _is_free(self, way: Sequence[Array]) -> bool:
        """Say whether pieces of a path, each (n, nq), are free of collisions."""
        pieces = [piece for piece in way if len(piece) > 1]
        coarse = self._still(np.vstack(pieces)) if pieces else np.zeros((0, len(self._weights)))
        if not len(coarse) or not self._free.are_free(coarse):
            return False
        between = np.linspace(0.0, 1.0, FIELDS.checks_between + 2)[1:-1, None, None]
        dense = [(p[:-1] + between * (p[1:] - p[:-1])).reshape(-1, self._nq) for p in pieces]
        return self._free.are_free(self._problem.space.unit(self._still(np.vstack(dense))))

    # The end

    def _ended(self, legs: list[Leg]) -> list[Leg] | None:
        """Return legs that end in the goal's centre, by changing the last; None if they fail."""
        kept, last = legs[: -FIELDS.last_legs], legs[-FIELDS.last_legs :]
        q = self._problem.start[: self._nq]
        for leg in kept:
            q = self.configurations(q, leg)[-1]
        fields = [leg.field for leg in last]
        lengths = np.array([leg.length for leg in last])
        large = self._longest[fields]
        for step in range(FIELDS.newton_steps + 1):
            raise_if_cancelled(self._cancelled)
            tried = np.vstack([lengths, lengths + FIELDS.fd_step * np.diag(large)])
            ends = self._ends(q, fields, tried)
            if not np.isfinite(ends).all():
                return None
            residuals = np.array([self._problem.goal_residual(x) for x in self._still(ends)])
            if np.linalg.norm(residuals[0]) < FIELDS.goal_tolerance:
                made = [Leg(f, float(a)) for f, a in zip(fields, lengths, strict=True)]
                return kept + made if self._is_allowed(q, made) else None
            if step == FIELDS.newton_steps:
                break
            slope = (residuals[1:] - residuals[0]).T / FIELDS.fd_step
            change = -np.linalg.lstsq(slope, residuals[0], rcond=FIELDS.rank_tolerance)[0]
            change *= min(1.0, FIELDS.max_change / max(np.abs(change).max(), 1e-300))
            lengths = lengths + change * large
        return None

    def _ends(self, q: Array, fields: Sequence[int], lengths: Array) -> Array:
        """Return where paths of several lengths (m, legs) end, shape (m, nq)."""
        ends = np.repeat(q[None], len(lengths), axis=0)
        for k, field in enumerate(fields):
            ends = self._followed(ends, field, lengths[:, k])[:, -1]
        return ends

    def _is_allowed(self, q: Array, legs: Sequence[Leg]) -> bool:
        """Say whether a path is within limits and free."""
        way = []
        for leg in legs:
            way.append(self.configurations(q, leg))
            q = way[-1][-1]
        return bool(self._within_limits(np.array(way)).all()) and self._is_free(way)


class _FieldTree:
    """A tree of configurations."""

    def __init__(self, root: Array) -> None:
        self.q, self._parents = root[None].copy(), [-1]
        self._legs: list[list[Leg]] = [[]]

    def add(self, q: Array, parent: int, legs: list[Leg]) -> int:
        self.q = np.vstack([self.q, q])
        self._parents.append(parent)
        self._legs.append(legs)
        return len(self._parents) - 1

    def legs(self, leaf: int) -> list[Leg]:
        """Return the legs from the root to a leaf, those of one field in a row as one."""
        branches = []
        while leaf >= 0:
            branches.append(self._legs[leaf])
            leaf = self._parents[leaf]
        joined: list[Leg] = []
        for leg in (leg for branch in reversed(branches) for leg in branch):
            if joined and joined[-1].field == leg.field:
                joined[-1] = Leg(leg.field, joined[-1].length + leg.length)
            else:
                joined.append(leg)
        return joined
