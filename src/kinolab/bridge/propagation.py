"""Propagation and validity, called back by OMPL: the compiled step, and FCL along it."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from kinolab.bridge.spaces import States
from kinolab.problem import Problem

RESOLUTION = 0.01  # [m] of motion between two collision checks inside a step
FINEST = 1e-4  # [m] of the same where the start is close to an obstacle
CAUTION = 1.1  # factor on the speeds at both ends of a step, for those in between


class Propagation:
    """Moves the machine by one step and judges the motion.

    Bodies and cables are inflated by half of a resolution and checked so often that their points
    move less than that between checks, so that what is accepted is free in between too, as far as
    the bound on the speed of their points holds. It is a filter: the verifier alone decides.

    Attributes:
        rejections: How many motions were refused, by cause.
    """

    def __init__(self, problem: Problem, states: States) -> None:
        self._problem, self._states = problem, states
        self._resolution = _resolution(problem)
        self._checker = problem.checker(margin=self._resolution / 2)
        self._calls = _Calls(problem)
        self._limits = [
            (i, float(lower), float(upper))
            for i, (lower, upper) in enumerate(problem.bounds)
            if np.isfinite(lower) or np.isfinite(upper)
        ]
        # These are checked in Python; most machines have none of them.
        self._has_rare_limits = bool(np.isfinite(problem.rate_bounds).any() or problem.keep_outs)
        self._workspace = [
            ("xyz".index(axis) * 4 + 3, lower, upper)
            for axis, (lower, upper) in problem.world.bounds.items()
        ]
        self._checker.collides(*problem.placement(problem.start))  # compiles what is compiled late
        self._last: tuple[list[float], bool] = ([], False)
        self.rejections = {"limit": 0, "collision": 0, "equations": 0}

    def propagate(self, state: Any, control: Any, duration: float, result: Any) -> None:
        """Write the state after one step; whether the way there is free is kept for is_valid."""
        calls = self._calls
        calls.x[:] = self._states.read(state)
        for i in range(len(calls.u)):
            calls.u[i] = control[i]
        failed = calls.step(duration)
        reached = calls.x[:] if failed else calls.next[:]
        if failed:
            self.rejections["equations"] += 1
        valid = not failed and self._free_on_the_way(duration)
        self._states.write(result, reached)
        self._last = (self._states.read(result), valid)

    def is_valid(self, state: Any) -> bool:
        """Say whether a state is within its limits and free; a state just reached, with its way."""
        values = self._states.read(state)
        if values == self._last[0]:
            return self._last[1]
        self._calls.next[:] = values
        return self._within_limits() and self._free()

    def _free_on_the_way(self, duration: float) -> bool:
        """Check the step just made, its end first."""
        calls = self._calls
        if not (
            self._within_limits()
            and self._turns_within_limits(duration)
            and calls.keeps_requirements(calls.before)
        ):
            self.rejections["limit"] += 1
            return False
        checks = max(1, math.ceil(CAUTION * calls.fastest() * duration / self._resolution))
        for k in range(checks, 0, -1):
            if k < checks:
                calls.step(duration * k / checks)
            if not calls.keeps_requirements(calls.after):
                self.rejections["limit"] += 1
                return False
            if not self._free():
                self.rejections["collision"] += 1
                return False
        return True

    def _free(self) -> bool:
        self._calls.frames()
        for row in self._calls.poses.tolist() if self._workspace else ():
            for entry, lower, upper in self._workspace:
                if not lower <= row[entry] <= upper:
                    return False
        return not self._checker.collides(self._calls.poses, self._calls.ends)

    def _within_limits(self) -> bool:
        values = self._calls.next
        for i, lower, upper in self._limits:
            if not lower <= values[i] <= upper:
                return False
        return not (self._has_rare_limits and any(self._problem.limit_violations(np.array(values))))

    def _turns_within_limits(self, duration: float) -> bool:
        """Check the limits of states that turn back within the step, whose extreme lies inside it.

        With slopes of opposite sign a and b at the ends of a step h, the extreme passes the ends
        by about h/2 |a b| / (|a| + |b|), at most h/2 of the smaller slope.
        """
        before, after = self._calls.slopes()
        for i, lower, upper in self._limits:
            a, b = before[i], after[i]
            if a * b < 0:
                overshoot = CAUTION * 0.5 * duration * min(abs(a), abs(b))
                ends = self._calls.x[i], self._calls.next[i]
                if min(ends) - overshoot < lower or max(ends) + overshoot > upper:
                    return False
        return True


def _resolution(problem: Problem) -> float:
    """Return the spacing of checks: fine enough that the start has room for half of it."""
    room = problem.checker().clearance(*problem.placement(problem.start))
    return float(np.clip(room, FINEST, RESOLUTION))


class _Calls:
    """The compiled functions on buffers made once: a callback must not allocate.

    Attributes:
        x: The state before a step.
        u: The inputs held during it.
        next: The state after it.
        poses: Of the bodies at ``next``, shape (bodies, 12).
        ends: Of the cables at ``next``, shape (cables, 6).
        before, after: The addresses of ``x`` and of ``next``.
    """

    def __init__(self, problem: Problem) -> None:
        model, bodies, cables = problem.model, len(problem.bodies), len(problem.cables)
        self.x: Any = (ctypes.c_double * model.nx)()
        self.next: Any = (ctypes.c_double * model.nx)()
        self.u: Any = (ctypes.c_double * model.nu)()
        self._speeds: Any = (ctypes.c_double * bodies)()
        self._cable_speeds: Any = (ctypes.c_double * cables)()
        self.poses, self.ends = np.zeros((bodies, 12)), np.zeros((cables, 6))
        self._has_cables = cables > 0
        self._p = model.parameter_vector()
        self._model = model  # owns the machine code behind the addresses
        pointer, number = ctypes.c_void_p, ctypes.c_double
        method = f"step_{problem.scenario.integration.method}"
        self._step = self._function(method, pointer, pointer, pointer, number, pointer)
        self._frames = self._function("frames", pointer, pointer, pointer)
        self._cables = self._function("cables", pointer, pointer, pointer)
        self._point_speed = self._function("point_speed", pointer, pointer, pointer, pointer)
        self._cable_speed = self._function("cable_speed", pointer, pointer, pointer, pointer)
        x, u, after, speeds = map(ctypes.addressof, (self.x, self.u, self.next, self._speeds))
        strung = ctypes.addressof(self._cable_speeds)
        p, poses, ends = self._p.ctypes.data, self.poses.ctypes.data, self.ends.ctypes.data
        self.before, self.after = x, after
        self._before_step, self._after_step = (x, u, p), (after, 0)
        self._poses_at, self._ends_at = (after, p, poses, 0), (after, p, ends, 0)
        self._speeds_at = ((x, u, p, speeds, 0), (after, u, p, speeds, 0))
        self._cable_speeds_at = ((x, u, p, strung, 0), (after, u, p, strung, 0))
        self._margins: Any = (ctypes.c_double * len(problem.system.requirements))()
        self._requirements = self._function("requirements", pointer, pointer, pointer, pointer)
        self._margins_at = (u, p, ctypes.addressof(self._margins), 0)
        self._f = self._function("f", pointer, pointer, pointer, pointer)
        self._slopes: Any = ((ctypes.c_double * model.nx)(), (ctypes.c_double * model.nx)())
        outs = map(ctypes.addressof, self._slopes)
        self._slopes_at = [(at, u, p, out, 0) for at, out in zip((x, after), outs, strict=True)]

    def _function(self, name: str, *types: Any) -> Callable[..., int]:
        prototype = ctypes.CFUNCTYPE(ctypes.c_int32, *types, ctypes.c_int64)
        return prototype(self._model.address(name))

    def step(self, duration: float) -> int:
        """Set ``next`` from ``x`` and ``u``; nonzero where that fails."""
        return self._step(*self._before_step, duration, *self._after_step)

    def frames(self) -> None:
        """Set ``poses`` and ``ends`` from ``next``."""
        self._frames(*self._poses_at)
        if self._has_cables:
            self._cables(*self._ends_at)

    def keeps_requirements(self, state: int) -> bool:
        """Check what the machine demands of the state at an address under the inputs held."""
        if not self._margins:
            return True
        self._requirements(state, *self._margins_at)
        return all(margin >= 0 for margin in self._margins)

    def slopes(self) -> Any:
        """Return the state's derivative at ``x`` and at ``next``."""
        for arguments in self._slopes_at:
            self._f(*arguments)
        return self._slopes

    def fastest(self) -> float:
        """Return a bound on the speed of the machine's points at ``x`` and at ``next``, in [m/s].

        The ends of a cable bound its points: each is a mean of the two, and so is its velocity.
        """
        largest = 0.0
        for arguments in self._speeds_at:
            self._point_speed(*arguments)
            largest = max(largest, *self._speeds)
        for arguments in self._cable_speeds_at if self._has_cables else ():
            self._cable_speed(*arguments)
            largest = max(largest, *self._cable_speeds)
        return largest
