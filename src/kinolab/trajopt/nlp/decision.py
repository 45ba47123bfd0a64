"""Decision variables of the trajectory optimisation, their scaling and bounds, and the cost."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.state_space import StateSpace
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.time_steps import covering_steps
from kinolab.trajectory import Trajectory
from kinolab.trajopt.nlp.options import SHORT


@dataclass(frozen=True, eq=False)
class Phases:
    """How a motion is divided at the transitions between modes: P phases, each in one mode.

    Attributes:
        begins: The first step of each phase but the first one, shape (P-1,).
        numbers: Of the transition in each of these steps, among those from its mode, from 1.
        ratios: Length of the steps of each phase, of the longest, shape (P,).
    """

    begins: NDArray[np.int64]
    numbers: tuple[int, ...]
    ratios: Array


ONE_PHASE = Phases(np.zeros(0, np.int64), (), np.ones(1))


@dataclass(frozen=True, eq=False)
class Knots:
    """Decision variables: states and inputs, with defects between them.

    Attributes:
        x: States, shape (N+1, nx); where a phase begins, those before the transition.
        u: Zero-order-hold inputs, shape (N, nu).
        h: Length of every step in [s], of the longest where phases have their own.
        phases: Of a motion in which transitions take place.
    """

    x: Array
    u: Array
    h: float
    phases: Phases = ONE_PHASE

    @property
    def lengths(self) -> Array:
        """Length of the steps of each phase in [s], shape (P,)."""
        return self.h * self.phases.ratios

    @property
    def phase(self) -> NDArray[np.int64]:
        """The phase of each step, shape (N,)."""
        return np.searchsorted(self.phases.begins, np.arange(len(self.u)), side="right")

    @property
    def counts(self) -> NDArray[np.int64]:
        """The number of steps of each phase, shape (P,)."""
        return np.diff(self.phases.begins, prepend=0, append=len(self.u))

    @property
    def duration(self) -> float:
        """Duration in [s]."""
        return float((self.counts * self.lengths).sum())

    @property
    def times(self) -> Array:
        """Times of the knots in [s], shape (N+1,)."""
        if self.phases is ONE_PHASE:
            return self.h * np.arange(len(self.u) + 1.0)
        return np.concatenate([[0.0], np.cumsum(self.lengths[self.phase])])

    def moved(self, dx: Array, du: Array, dh: Array) -> Knots:
        """Return the knots plus a step: dx (N+1, nx), du (N, nu), dh in [s], shape (P,)."""
        x = self.x + dx
        if self.phases is not ONE_PHASE:
            x[:, -1] = self.x[:, -1]  # a mode that differs by rounding is another one
        return replace(self, x=x, u=self.u + du).with_lengths(self.lengths + dh)

    def with_lengths(self, lengths: Array) -> Knots:
        """Return the knots with steps of other lengths in [s], shape (P,)."""
        h = float(lengths.max())
        if self.phases is ONE_PHASE:
            return replace(self, h=h)
        return replace(self, h=h, phases=replace(self.phases, ratios=lengths / h))

    def in_steps(self, count: int, space: StateSpace) -> Knots:
        """Resample to ``count`` steps over the same duration, by ``resampled``."""
        return resampled(self.times, self.x, self.u, count, space)


def resampled(t: Array, x: Array, u: Array, count: int, space: StateSpace) -> Knots:
    """Resample a motion to ``count`` equal steps over the same duration.

    States are interpolated linearly, inputs are averaged over each step.

    Args:
        t: Times in [s], shape (N+1,).
        x: States, shape (N+1, nx).
        u: Inputs, shape (N, nu).
        space: The state space; quaternions are normalised.
    """
    times = np.linspace(t[0], t[-1], count + 1)
    states = space.unit(np.column_stack([np.interp(times, t, column) for column in x.T]))
    impulse = np.vstack([np.zeros(u.shape[1]), np.cumsum(u * np.diff(t)[:, None], axis=0)])
    total = np.column_stack([np.interp(times, t, column) for column in impulse.T])
    h = float(t[-1] - t[0]) / count
    held = np.diff(total, axis=0).reshape(count, u.shape[1]) / h
    return Knots(states, held, h)


@dataclass(frozen=True, eq=False)
class Scaling:
    """Scales and bounds of the decision variables.

    Attributes:
        x: State scales, shape (nx,).
        u: Input scales, shape (nu,).
        x_bounds: Lower and upper state bounds, shape (nx, 2).
        u_bounds: Lower and upper input bounds, shape (nu, 2).
        h_bounds: Shortest and longest step in [s], or those of each phase, shape (P,) each.
    """

    x: Array
    u: Array
    x_bounds: Array
    u_bounds: Array
    h_bounds: tuple[float | Array, float | Array]


@dataclass(frozen=True)
class Weights:
    """Weights of the cost and the merit function.

    Attributes:
        time: Of the duration, per [s].
        effort: Of the mean square scaled input.
        stay: Of the mean square scaled change of states and inputs (proximal term).
        penalty: Of the constraint violation: defects, goal and inequalities.
        spent: Of what the motion has cost at its end.
        entry: The entry of the state that is this cost, where there is one.
    """

    time: float
    effort: float
    stay: float
    penalty: float
    spent: float = 0.0
    entry: int = -1


def cost(knots: Knots, scaling: Scaling, weights: Weights) -> float:
    """Cost of a trajectory without the penalty on constraint violation."""
    effort = float(np.mean((knots.u / scaling.u) ** 2)) if knots.u.size else 0.0
    spent = weights.spent * float(knots.x[-1, weights.entry])
    return weights.time * knots.duration + weights.effort * effort + spent


def even_knots(problem: PlanningTask, trajectory: Trajectory) -> Knots:
    """Return a trajectory as knots with equal steps, none longer than the problem's."""
    steps, h = len(trajectory.inputs), problem.step
    spans = np.diff(trajectory.t)
    even = (
        np.abs(spans - spans[0]).max() <= SHORT.even_step_tolerance
        and spans[0] <= h + SHORT.even_step_tolerance
    )
    if even:
        return Knots(trajectory.x, trajectory.inputs, float(spans[0]))
    count = max(steps, SHORT.min_steps, covering_steps(trajectory.duration, h))
    space = problem.space
    return resampled(trajectory.t, trajectory.x, trajectory.inputs, count, space)
