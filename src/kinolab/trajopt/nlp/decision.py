"""Decision variables of the trajectory optimisation, their scaling and bounds, and the cost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.dynamics.codegen.state_space import StateSpace
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.time_steps import covering_steps
from kinolab.trajectory import Trajectory
from kinolab.trajopt.options import SHORT


@dataclass(frozen=True, eq=False)
class Knots:
    """Decision variables: states and inputs, with defects between them.

    Attributes:
        x: States, shape (N+1, nx).
        u: Zero-order-hold inputs, shape (N, nu).
        h: Length of every step in [s].
    """

    x: Array
    u: Array
    h: float

    @property
    def duration(self) -> float:
        """Duration in [s]."""
        return len(self.u) * self.h

    def moved(self, dx: Array, du: Array, dh: float) -> Knots:
        """Return the knots plus a step: dx (N+1, nx), du (N, nu), dh in [s]."""
        return Knots(self.x + dx, self.u + du, self.h + dh)

    def in_steps(self, count: int, space: StateSpace) -> Knots:
        """Resample to ``count`` steps over the same duration, by ``resampled``."""
        times = self.h * np.arange(len(self.u) + 1.0)
        return resampled(times, self.x, self.u, count, space)


def resampled(t: Array, x: Array, u: Array, count: int, space: StateSpace) -> Knots:
    """Resample a motion to ``count`` equal steps over the same duration.

    States are interpolated linearly, inputs are averaged over each step.

    Args:
        t: Times in [s], shape (N+1,).
        x: States, shape (N+1, nx).
        u: Inputs, shape (N, nu).
        count: Number of steps.
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
        h_bounds: Shortest and longest step in [s].
    """

    x: Array
    u: Array
    x_bounds: Array
    u_bounds: Array
    h_bounds: tuple[float, float]


@dataclass(frozen=True)
class Weights:
    """Weights of the cost and the merit function.

    Attributes:
        time: Of the duration, per [s].
        effort: Of the mean square scaled input.
        stay: Of the mean square scaled change of states and inputs (proximal term).
        penalty: Of the constraint violation: defects, goal and inequalities.
    """

    time: float
    effort: float
    stay: float
    penalty: float


def cost(knots: Knots, scaling: Scaling, weights: Weights) -> float:
    """Cost of a trajectory without the penalty on constraint violation."""
    effort = float(np.mean((knots.u / scaling.u) ** 2)) if knots.u.size else 0.0
    return weights.time * knots.duration + weights.effort * effort


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
