"""Initial guesses for trajectory optimisation: geometric paths with a time scaling.

They need not satisfy the dynamics: they may slip sideways, hover in the air or jump in velocity.
What matters is their duration and their homotopy class, the side on which they pass obstacles.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.state_space import whole_turns
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.steering.cyclic_coordinates import cyclic_coordinates
from kinolab.trajopt.multistart.allowed_velocities import velocities_along
from kinolab.trajopt.nlp.decision import Knots, resampled
from kinolab.trajopt.nlp.options import GUESS


class Guesses:
    """Initial guesses for one problem."""

    def __init__(self, problem: PlanningTask, generator: np.random.Generator) -> None:
        self._problem, self._generator = problem, generator
        self._aim = problem.start

    def aim(self, is_free: Callable[[Array], bool]) -> None:
        """Choose anew where paths end, if the goal places points or has formulas.

        Args:
            is_free: Says whether a state, shape (nx,), is free of collisions.
        """
        if not (self._problem.goal.points or self._problem.goal.formulas):
            return
        drawn = (self._problem.sample_goal(self._generator, 0.0) for _ in range(GUESS.max_aims))
        free = islice(filter(is_free, drawn), GUESS.compared_aims)
        self._aim = min(free, key=lambda x: self.quickest(self._to(x)), default=self._aim)

    def straight(self, turns: Sequence[int] = ()) -> Array:
        """Return the straight path from start to goal, shape (2, nx).

        Coordinates that the goal leaves free stay as at the start, or as ``aim`` has chosen them,
        except that velocities vanish and bodies are placed and turned by the least motion that
        takes points and axes to their targets.

        Args:
            turns: Extra whole turns of each circular angle beyond the shortest path, signed; none
                if empty.
        """
        return self._to(self._aim, turns)

    def _to(self, aim: Array, turns: Sequence[int] = ()) -> Array:
        """Return the straight path from the start to the goal's state nearest to one, (2, nx)."""
        problem, goal = self._problem, self._problem.goal
        start, end = problem.start, aim.copy()
        end[problem.model.nq :] = 0.0
        end = goal.centre(end)
        for part in (one.part for one in goal.parts):
            end[part.own] = part.nearest(start[part.own], end[part.own])
        end = problem.with_bodies_placed(end[None])[0]
        circles = self.circles
        end[circles] -= whole_turns(end[circles] - start[circles])
        if len(turns):
            end[circles] += 2 * np.pi * np.asarray(turns)
        return np.stack([start, end])

    def winding(self) -> Array:
        """Return a path via one random configuration with random extra turns, shape (3, nx)."""
        problem, generator = self._problem, self._generator
        nq = problem.model.nq
        turns = generator.integers(-1, 2, len(self.circles))
        begin, end = self.straight(turns.tolist())
        via = (begin + end) / 2
        lower, upper = problem.sampling_bounds[:nq].T
        aside = GUESS.max_detour * generator.uniform(-1.0, 1.0, nq) * (upper - lower)
        for part in problem.space.spheres:
            aside[part.own] = 0.0
        via[:nq] += aside
        return np.stack([begin, via, end])

    @cached_property
    def circles(self) -> NDArray[np.int64]:
        """Coordinates that are angles on the circle."""
        return np.flatnonzero(self._problem.circular[: self._problem.model.nq])

    def quickest(self, path: Array) -> float:
        """Estimate the minimum time in [s] of a motion along a path, shape (m, nx).

        Maximum rates are taken over random states and inputs, so the estimate may be some percent
        too long; acceleration is neglected.
        """
        return float(self.least_times(path))

    def least_times(self, paths: Array) -> Array:
        """Do what ``quickest`` does for several paths, shape (..., m, nx)."""
        return np.asarray(self.leg_times(paths).sum(axis=-1))

    def knots(self, path: Array, steps: int, h: float) -> Knots:
        """Return knots along a path, timed by the minimum time of each leg.

        Inputs are at the middle of their ranges plus a little noise. If some coordinates are
        cyclic, velocities follow the path and these follow the velocities.

        Args:
            path: Shape (m, nx).
            h: Step length in [s].
        """
        problem, generator = self._problem, self._generator
        times = np.concatenate([[0.0], np.cumsum(self.leg_times(path))])  # of arrival, in [s]
        if not times[-1] > 0:  # same configuration, other velocities
            times = np.linspace(0.0, 1.0, len(path))
        lower, upper = np.clip(problem.model.control_bounds.T, -1e3, 1e3)
        held = np.tile((lower + upper) / 2, (len(path) - 1, 1))
        even = resampled(times, path, held, steps, problem.space)
        for clock in problem.model.clocks:  # whatever a path has there
            even.x[:, clock] = problem.start[clock] + h * np.arange(steps + 1)
        shaken = GUESS.perturbation * generator.standard_normal(even.u.shape) * (upper - lower)
        return _rolled(problem, Knots(even.x, even.u + shaken, h))

    def leg_times(self, paths: Array) -> Array:
        """Return times in [s] at the maximum rates for legs of paths (..., m, nx), (..., m-1)."""
        at = paths[..., : self._problem.model.nq]
        needed = np.abs(at[..., 1:, :] - at[..., :-1, :]) / self._fastest
        return np.asarray(needed.max(axis=-1, initial=0.0))

    @cached_property
    def starting(self) -> float:
        """Estimate the time in [s] from rest to the limit of the slowest velocity."""
        problem = self._problem
        limits = np.abs(problem.bounds[problem.model.nq :]).max(axis=1, initial=0.0)
        slopes = np.median(np.abs(self._slopes[:, problem.model.nq :]), axis=0)
        times = limits[np.isfinite(limits)] / np.maximum(slopes[np.isfinite(limits)], 1e-9)
        return float(times[times < GUESS.unlimited].max(initial=0.0))

    @cached_property
    def _fastest(self) -> Array:
        """Largest sampled rate of each coordinate in its unit per [s], shape (nq,)."""
        rates = np.abs(self._slopes[:, : self._problem.model.nq]).max(axis=0)
        seen: Array = np.maximum(rates, 1e-9)
        seen[self._problem.model.clocks] = np.inf  # time has no way to go
        return seen

    @cached_property
    def _slopes(self) -> Array:
        """State derivatives at random states and inputs, shape (speed_samples, nx)."""
        problem, generator = self._problem, np.random.default_rng(0)
        model = problem.model
        lower, upper = np.clip(problem.sampling_bounds.T, -1e3, 1e3)
        x = model.space.unit(generator.uniform(lower, upper, (GUESS.speed_samples, model.nx)))
        lower, upper = np.clip(model.control_bounds.T, -1e3, 1e3)
        u = generator.uniform(lower, upper, (GUESS.speed_samples, model.nu))
        slopes: Array = np.stack([model.f(a, b) for a, b in zip(x, u, strict=True)])
        return slopes


def path_time_scaling(problem: PlanningTask, knots: Knots) -> Knots:
    """Return knots with the velocities that best follow the configurations.

    Coordinate rates are linear in the machine's velocities, which are solved for by least squares.
    The first and last knots stay as they are.

    Args:
        knots: Configurations along a path; velocities are overwritten.
    """
    x, nq = knots.x.copy(), problem.model.nq
    if len(x) < 3 or nq == x.shape[1]:
        return knots
    matters = np.flatnonzero(~cyclic_coordinates(problem)[:nq])
    rates = (x[2:, matters] - x[:-2, matters]) / (2 * knots.h)
    speeds = velocities_along(problem, x[1:-1], rates, matters)
    x[1:-1, nq:] = np.clip(speeds, *problem.bounds[nq:].T)
    return Knots(x, knots.u, knots.h)


def _rolled(problem: PlanningTask, knots: Knots) -> Knots:
    """Return knots whose cyclic coordinates, if there are any, are integrals of their rates.

    A wheel that would have to roll all the way in one step of the optimiser costs so much change
    that it rather gives up the goal.
    """
    nq = problem.model.nq
    rolling = np.flatnonzero(cyclic_coordinates(problem)[:nq])
    if not len(rolling):
        return knots
    timed = path_time_scaling(problem, knots)
    idle = np.clip(problem.model.control_bounds, -1e3, 1e3).mean(axis=1)
    rates = problem.model.f(timed.x, np.tile(idle, (len(timed.x), 1)))[:, rolling]
    moved = np.cumsum((rates[1:] + rates[:-1]) / 2 * knots.h, axis=0)
    x = timed.x.copy()
    x[1:, rolling] = x[0, rolling] + moved
    return Knots(x, timed.u, knots.h)
