"""Propagation and validity, called back by OMPL: the compiled step, and FCL along it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from kinolab.bridge.compiled_step import CompiledStep
from kinolab.bridge.spaces import States
from kinolab.bridge.sweep import Sweep
from kinolab.problem import Problem

TURN = 0.01  # [rad] of an axis between two looks at a forbidden cone
INSTANT = 1e-6  # [s] over which the speed of an axis is measured
CAUTION = 1.1  # factor on what is measured at both ends of a step, for what lies in between


class Propagation:
    """Moves the machine by one step and judges the motion.

    What is accepted is free between its ends too, as far as the bound on the speed of the
    machine's points holds. It is a filter: the verifier alone decides.

    Attributes:
        rejections: How many motions were refused, by cause.
    """

    def __init__(self, problem: Problem, states: States) -> None:
        self._problem, self._states = problem, states
        self._calls = CompiledStep(problem)
        self._sweep = Sweep(problem, self._calls)
        self._limits = [
            (i, float(lower), float(upper))
            for i, (lower, upper) in enumerate(problem.bounds)
            if np.isfinite(lower) or np.isfinite(upper)
        ]
        # These are checked in Python; most machines have none of them.
        self._has_rare_limits = bool(np.isfinite(problem.rate_bounds).any() or problem.keep_outs)
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

    def forget(self) -> None:
        """Forget the step made last, whose end may be the state that a planner begins from."""
        self._last = ([], False)

    def is_valid(self, state: Any) -> bool:
        """Say whether a state is within its limits and free; a state just reached, with its way."""
        values = self._states.read(state)
        if values == self._last[0]:
            return self._last[1]
        self._calls.next[:] = values
        return self._within_limits() and self._sweep.free()

    def _free_on_the_way(self, duration: float) -> bool:
        """Check the step just made."""
        if not (
            self._within_limits()
            and self._turns_within_limits(duration)
            and self._calls.keeps_requirements(duration)
            and self._stays_out_of_cones(duration)
        ):
            self.rejections["limit"] += 1
            return False
        if not self._sweep.free_within(duration, CAUTION * self._calls.fastest()):
            self.rejections["collision"] += 1
            return False
        return True

    def _within_limits(self) -> bool:
        values = self._calls.next
        for i, lower, upper in self._limits:
            if not lower <= values[i] <= upper:
                return False
        return not (self._has_rare_limits and any(self._problem.limit_violations(np.array(values))))

    def _stays_out_of_cones(self, duration: float) -> bool:
        """Check forbidden cones so often along the step that no axis turns far in between."""
        cones, calls = self._problem.keep_outs, self._calls
        if not cones:
            return True
        ends = zip((calls.x, calls.next), calls.slopes(), strict=True)
        fastest = max(_axis_speed(self._problem, np.array(x), np.array(dx)) for x, dx in ends)
        looks = max(1, math.ceil(CAUTION * fastest * duration / TURN))
        for k in range(1, looks + 1):
            calls.step(duration * k / looks)
            poses = self._problem.frames(np.array(calls.next))
            if any(cone.angle(poses) < cone.half_angle for cone in cones):
                return False
        return True

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


def _axis_speed(problem: Problem, x: np.ndarray, slope: np.ndarray) -> float:
    """Return how fast the fastest axis with a forbidden cone turns at a state, in [rad/s]."""
    before, after = problem.frames(np.stack([x, x + INSTANT * slope]))
    turned = (after - before).reshape(-1, 3, 4)[:, :, :3]
    return max(
        float(np.linalg.norm(turned[cone.body] @ cone.axis)) / INSTANT for cone in problem.keep_outs
    )
