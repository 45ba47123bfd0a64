"""Steering between two states by every method that a machine allows, the most reliable first."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain

import numpy as np

from kinolab.concurrency.cancel import CancellationToken, never_cancelled
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.time_steps import covering_steps
from kinolab.simulation.rollout import Rollout
from kinolab.steering.maneuver import Maneuver
from kinolab.steering.nearest_equilibrium import nearest_equilibrium
from kinolab.steering.path_families import path_family
from kinolab.steering.path_motion import MAX_STEPS, PathMotion
from kinolab.steering.stop_maneuver import StopManeuver
from kinolab.steering.terminal_correction import TerminalCorrection
from kinolab.steering.tracking import TrackingLaw


class Steering:
    """All steering methods that a machine allows.

    To rest: curves of a flat machine, after a stop maneuver if it moves. Otherwise: feedback about
    the end if that is a stabilisable equilibrium, and a boundary-value problem by shooting.

    Args:
        stop: Cancellation token; cancelling raises a CancelledError.

    Attributes:
        rollout: Simulates inputs.
        closing: Terminal correction of motions.
        tracker: Feedback along motions.
        brake: Stop maneuvers.
        family: The path family; for machines that are not flat its paths may be infeasible.
        paths: Motions along its paths; None if the machine has attitudes.
        flat: Whether the machine is differentially flat.
        reversible: Whether the reverse motion sweeps the same volume.
    """

    def __init__(self, problem: PlanningTask, stop: CancellationToken = never_cancelled) -> None:
        self._problem = problem
        self.rollout = Rollout(problem, stop)
        self.closing = TerminalCorrection(problem, self.rollout)
        self.tracker = TrackingLaw(problem, self.rollout)
        self.brake = StopManeuver(problem, self.rollout, self.closing, self.tracker)
        self.family = path_family(problem)
        vectors = bool(problem.space.spheres)
        self.paths = None if vectors else PathMotion(problem, self.family.coordinates, stop)
        self.flat = problem.machine.flat is not None
        # The reverse motion follows the same curves and collides with the same obstacles, where all
        # velocity limits are symmetric.
        limits = np.vstack([problem.bounds[problem.model.speeds], problem.rate_bounds])
        self.reversible = self.flat and bool((limits[:, 0] == -limits[:, 1]).all())

    def steer(
        self, x0: Array, x1: Array, worthwhile: Callable[[Array], bool] = lambda _: True
    ) -> Iterator[Maneuver]:
        """Yield motions from x0 that end exactly at x1.

        Args:
            x0: Start state, shape (nx,).
            x1: End state, shape (nx,).
            worthwhile: Whether states along a path, shape (n, nx), justify computing its motion;
                False, for example, if one collides.
        """
        x1 = self._problem.space.nearest(x0, x1)
        for rough in self._rough(x0, x1, worthwhile):
            # 25 Newton steps of a boundary-value problem
            exact = self.closing.correct(x0, rough.u, x1, most=25)
            if exact is not None:
                yield exact

    def _rough(
        self, x0: Array, x1: Array, worthwhile: Callable[[Array], bool]
    ) -> Iterator[Maneuver]:
        """Yield motions that end near x1."""
        if self.flat and self._problem.rests(x0) and self._problem.rests(x1):
            yield from self._along_curves(x0, x1, worthwhile)
            return
        stopped = self.brake.stop(x0) if self.flat and self._problem.rests(x1) else None
        if stopped is not None:
            yield from self._onward(stopped, x1, worthwhile)
            return
        settled = nearest_equilibrium(self._problem, x1)
        if settled is not None and np.abs(self.closing.residual(settled[0], x1)).max() < 1e-6:
            # 60 steps of feedback toward an equilibrium
            held = self.tracker.settle_at(x0, x1, settled[1], 60)
            if held is not None:
                yield held
        yield from self._idle(x0, x1)

    def _along_curves(
        self, x0: Array, x1: Array, worthwhile: Callable[[Array], bool]
    ) -> Iterator[Maneuver]:
        assert self.paths is not None
        for paths in chain(self.family.paths(x0, x1), self.family.detours(x0, x1)):
            # From the end, where clearance is most often smallest.
            if all(worthwhile(self.paths.sample_states(path, x0)) for path in reversed(paths)):
                motion = self.paths.chain(paths, x0)
                if motion is not None:
                    yield motion

    def _onward(
        self, stopped: Maneuver, x1: Array, worthwhile: Callable[[Array], bool]
    ) -> Iterator[Maneuver]:
        """Yield motions that continue a stop maneuver to x1."""
        if not worthwhile(stopped.x):
            return
        rest = stopped.x[-1].copy()
        rest[self._problem.model.nq :] = x1[self._problem.model.nq :]  # exactly 0
        for onward in self._along_curves(rest, x1, worthwhile):
            yield stopped.then(onward)

    def _idle(self, x0: Array, x1: Array) -> Iterator[Maneuver]:
        """Yield guesses for a boundary-value problem: inputs blended between both equilibria's."""
        begin, end = (nearest_equilibrium(self._problem, x) for x in (x0, x1))
        idle = self._problem.model.null_control()
        u0, u1 = (idle if found is None else found[1] for found in (begin, end))
        # Durations of a boundary-value problem, relative to the estimated duration
        for factor in (1.0, 2.0, 4.0):
            steps = max(covering_steps(factor * self._duration(x0, x1), self.rollout.step), 4)
            if steps > MAX_STEPS:
                return
            fraction = (np.arange(steps)[:, None] + 0.5) / steps
            inputs = u0 + fraction * (u1 - u0)
            states = self.rollout.follow(x0, inputs)
            if states is not None:
                yield Maneuver(states, inputs)

    def _duration(self, x0: Array, x1: Array) -> float:
        """Estimate the duration in [s] from the limits or scales of the rates."""
        model = self._problem.model
        miss = np.abs(self.closing.residual(x0, x1) * self._problem.scales)[: model.nq]
        speeds = np.array([_speed(self._problem, name) for name in model.coordinate_names])
        return float(np.max(miss / speeds, initial=0.5)) * 1.5


def _speed(problem: PlanningTask, coordinate: str) -> float:
    """Return the speed limit of a coordinate, or its scale per second."""
    found = {c.name: c for c in problem.machine.coordinates}.get(coordinate)
    speed = getattr(found, "speed", np.inf)
    return float(speed if np.isfinite(speed) else getattr(found, "scale", 1.0))
