"""The unknowns, what counts as large of them, what is allowed, and what a trajectory costs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kinolab.dynamics.codegen.state_space import StateSpace
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.trajopt.options import SHORT


@dataclass(frozen=True, eq=False)
class Knots:
    """States and inputs that need not belong together yet.

    Attributes:
        x: States, shape (N+1, nx).
        u: Inputs held between them, shape (N, nu).
        h: Length of every step in [s].
    """

    x: Array
    u: Array
    h: float

    @property
    def duration(self) -> float:
        """Length in time, in [s]."""
        return len(self.u) * self.h

    def moved(self, dx: Array, du: Array, dh: float) -> Knots:
        """Return knots that differ by so much."""
        return Knots(self.x + dx, self.u + du, self.h + dh)

    def in_steps(self, count: int, space: StateSpace) -> Knots:
        """Return as many steps of the same duration, by ``resampled``."""
        times = self.h * np.arange(len(self.u) + 1.0)
        return resampled(times, self.x, self.u, count, space)


def resampled(t: Array, x: Array, u: Array, count: int, space: StateSpace) -> Knots:
    """Return as many even steps along a motion, stretched in time so that it has its duration.

    States are interpolated on the straight line, inputs are averaged over each step.

    Args:
        t: Times in [s], shape (N+1,).
        x: States, shape (N+1, nx).
        u: Inputs, shape (N, nu).
        count: Number of steps.
        space: Of the states; quaternions come out of unit length.
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
    """What counts as large, and what is allowed.

    Attributes:
        x: Shape (nx,).
        u: Shape (nu,).
        x_bounds: Lower and upper limits, shape (nx, 2).
        u_bounds: Shape (nu, 2).
        h_bounds: Shortest and longest step in [s].
    """

    x: Array
    u: Array
    x_bounds: Array
    u_bounds: Array
    h_bounds: tuple[float, float]


@dataclass(frozen=True)
class Weights:
    """What a trajectory costs.

    Attributes:
        time: Of its duration, per [s].
        effort: Of the mean square of its inputs, as shares of their limits.
        stay: Of the mean square change of states and inputs, as shares of what counts as large.
        penalty: Of what is missing: defects, goal and inequalities.
    """

    time: float
    effort: float
    stay: float
    penalty: float


def cost(knots: Knots, scaling: Scaling, weights: Weights) -> float:
    """Return what a trajectory costs apart from what is missing."""
    effort = float(np.mean((knots.u / scaling.u) ** 2)) if knots.u.size else 0.0
    return weights.time * knots.duration + weights.effort * effort


def even_knots(problem: PlanningTask, trajectory: Trajectory) -> Knots:
    """Return a trajectory as knots with even steps, none longer than the problem's."""
    steps, h = len(trajectory.inputs), problem.step
    spans = np.diff(trajectory.t)
    even = (
        np.abs(spans - spans[0]).max() <= SHORT.even_step_tolerance
        and spans[0] <= h + SHORT.even_step_tolerance
    )
    if even:
        return Knots(trajectory.x, trajectory.inputs, float(spans[0]))
    count = max(
        steps, SHORT.min_steps, math.ceil(trajectory.duration / h - SHORT.even_step_tolerance)
    )
    space = problem.space
    return resampled(trajectory.t, trajectory.x, trajectory.inputs, count, space)
