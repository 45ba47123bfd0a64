"""Motions along paths of fully actuated machines, by inputs that the equations of motion give.

Each leg begins and ends at rest: its speed rises smoothly, stays, and falls. Of a few shapes, the
one that takes least time is chosen.

Source: Lynch, Park, Modern Robotics, 2017, sections 9.2 (straight paths with a time scaling) and
11.4 (computed torque).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.time_steps import covering_steps
from kinolab.trajopt.multistart.allowed_velocities import velocity_directions
from kinolab.trajopt.nlp.decision import Knots
from kinolab.trajopt.nlp.options import TIMING

SAMPLES = 16  # configurations of a leg between its ends and at them


def along_corners(problem: PlanningTask, path: Array) -> Knots | None:
    """Return a motion from corner to corner with stops between; None if inputs do not suffice.

    Args:
        problem: The planning problem of a machine that follows every path.
        path: Corners, shape (m, nx).
    """
    nq, parts = problem.model.nq, []
    for begin, end in pairwise(path[:, :nq]):
        # 1e-6 of a coordinate's scale: corners closer together are one
        if (np.abs(end - begin) <= 1e-6 * problem.scales[:nq]).all():
            continue
        part = _timed(problem, LegCurve.straight(problem, begin, end))
        if part is None:
            return None
        parts.append(part)
    if not parts:
        return None
    x = np.vstack([parts[0].x[:1], *(part.x[1:] for part in parts)])
    return Knots(x, np.vstack([part.u for part in parts]), parts[0].h)


@dataclass(frozen=True, eq=False)
class LegCurve:
    """A leg of a path, by the fraction of its length from 0 to 1.

    Attributes:
        q: Configurations, shape (n, nq), evenly spaced.
        v: Velocities per unit of the fraction, shape (n, nv).
    """

    q: Array
    v: Array

    @classmethod
    def straight(cls, problem: PlanningTask, begin: Array, end: Array) -> LegCurve:
        """Return the straight leg between two configurations (nq,)."""
        q = begin + np.linspace(0.0, 1.0, SAMPLES)[:, None] * (end - begin)
        still, rates = np.zeros((SAMPLES, problem.model.nv)), np.tile(end - begin, (SAMPLES, 1))
        x, everything = np.hstack([q, still]), np.arange(len(begin))
        directions = velocity_directions(problem, x, everything)
        return cls(q, (np.linalg.pinv(directions) @ rates[..., None])[..., 0])

    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """Return q, v and dv/ds at fractions (m,), interpolated linearly."""
        grid = np.linspace(0.0, 1.0, len(self.q))
        bent = np.gradient(self.v, grid, axis=0, edge_order=2)
        q, v, slope = (
            np.column_stack([np.interp(s, grid, column) for column in table.T])
            for table in (self.q, self.v, bent)
        )
        return q, v, slope


def profile(b: float, times: Array) -> tuple[Array, Array, Array]:
    """Return how the fraction s of a leg grows from rest to rest: s, ds/dt and its derivative.

    Args:
        b: Fraction of the duration in which the speed rises, and falls, at most 1/2.
        times: From 0 to 1, shape (m,).
    """
    top = 1.0 / (1.0 - b)
    early = np.minimum(np.minimum(times, 1.0 - times), b)  # time since rest, or until rest
    rising, falling = times < b, times > 1.0 - b
    s = top / 2 * (early - b / np.pi * np.sin(np.pi * early / b))
    s = np.where(falling, 1.0 - s, s + top * np.clip(times - b, 0.0, 1.0 - 2 * b))
    speed = top * np.sin(np.pi * early / (2 * b)) ** 2
    gain = top * np.pi / (2 * b) * np.sin(np.pi * early / b)
    return s, speed, np.where(rising, gain, np.where(falling, -gain, 0.0))


def _timed(problem: PlanningTask, curve: LegCurve) -> Knots | None:
    """Return a leg from rest to rest in whole steps; None if it needs more than the inputs have."""
    quickest = [(_least_duration(problem, curve, ramp), ramp) for ramp in TIMING.ramps]
    duration, ramp = min(quickest, key=lambda pair: pair[0])
    if not math.isfinite(duration):
        return None
    h = problem.step
    count = max(1, covering_steps(duration, h))
    times = np.linspace(0.0, 1.0, count * TIMING.samples_per_step + 1)
    x, u = _motion(problem, curve, ramp, count * h, times)
    knots = x[:: TIMING.samples_per_step]
    if problem.machine.references is not None:  # the law looks at the state when a step begins
        accelerations = np.diff(knots[:, problem.model.nq :], axis=0) / h
        return Knots(knots, inverse_dynamics(problem, knots[:-1], accelerations), h)
    held = u[:-1] + np.diff(u, axis=0) / 2
    held = held.reshape(count, TIMING.samples_per_step, -1).mean(axis=1)
    return Knots(knots, held, h)


def _least_duration(problem: PlanningTask, curve: LegCurve, ramp: float) -> float:
    """Return the shortest duration in [s] that limits allow, by bisection; infinite if none."""
    times = np.linspace(0.0, 1.0, TIMING.limit_samples)
    low, high = TIMING.durations
    if not _allowed(problem, curve, ramp, high, times):
        return math.inf
    for _ in range(TIMING.bisections):
        middle = math.sqrt(low * high)
        if _allowed(problem, curve, ramp, middle, times):
            high = middle
        else:
            low = middle
    return high


def _allowed(
    problem: PlanningTask, curve: LegCurve, ramp: float, duration: float, times: Array
) -> bool:
    model, used = problem.model, TIMING.used
    x, u = _motion(problem, curve, ramp, duration, times)
    lower, upper = problem.bounds[model.nq :].T * used
    v = x[:, model.nq :]
    if ((v < lower) | (v > upper)).any():
        return False
    lowest, highest = problem.rate_bounds.T * used
    rates = model.velocity(x)
    if ((rates < lowest) | (rates > highest)).any():
        return False
    given = [(model, u)]
    if model.plant is not model:  # a law that saturates does not do what is asked for
        given.append((model.plant, model.plant_inputs(x, u)))
    return all(_within(inputs, whose.control_bounds, used) for whose, inputs in given)


def _within(u: Array, limits: Array, used: float) -> bool:
    """Say whether inputs (m, nu) use no more than a fraction of their limits (nu, 2)."""
    weakest, strongest = np.clip(limits, -1e9, 1e9).T  # magnitude of an input without limits
    half = (strongest - weakest) / 2 * used
    return bool((np.abs(u - (weakest + strongest) / 2) <= half).all())


def _motion(
    problem: PlanningTask, curve: LegCurve, ramp: float, duration: float, times: Array
) -> tuple[Array, Array]:
    """Return states (m, nx) and inputs (m, nu) at fractions of a duration."""
    s, speed, gain = profile(ramp, times)
    q, v, slope = curve.at(s)
    speed, gain = (speed / duration)[:, None], (gain / duration**2)[:, None]
    x = problem.space.unit(np.hstack([q, v * speed]))
    wanted = v * gain + slope * speed**2
    return x, inverse_dynamics(problem, x, wanted)


def inverse_dynamics(problem: PlanningTask, x: Array, accelerations: Array) -> Array:
    """Return the least inputs (m, nu) that come nearest to accelerations (m, nv) at states."""
    model = problem.model
    idle = np.tile(model.null_control(), (len(x), 1))
    effect = model.jacobian(x, idle)[1][:, model.nq :]
    lacking = accelerations - model.f(x, idle)[:, model.nq :]
    u: Array = idle + (np.linalg.pinv(effect) @ lacking[..., None])[..., 0]
    return u
