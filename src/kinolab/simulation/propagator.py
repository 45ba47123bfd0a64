"""State propagation with limit and FCL collision checks, and statistics of rejections."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.simulation.compiled_step import CompiledStep
from kinolab.simulation.continuous_collision import SAFETY_FACTOR, ContinuousCollisionCheck

CONE_RESOLUTION = 0.01  # [rad] that an axis may turn between two checks of a keep-out cone
# rejections of each cause that are explained; beyond them one in EXPLANATION_PERIOD
FULLY_EXPLAINED = 200
EXPLANATION_PERIOD = 32


class Rejections:
    """Counts of rejected motions by cause and source.

    Finding a source can cost more than the propagation, so only a sample is explained: all of the
    first ones, then one in ``EXPLANATION_PERIOD``, weighted by as many.

    Attributes:
        counts: Rejected motions by cause: ``limit``, ``collision`` or ``equations``.
    """

    def __init__(self) -> None:
        self.counts = {"limit": 0, "collision": 0, "equations": 0}
        self._culprits: Counter[tuple[str, str]] = Counter()

    def add(self, cause: str, culprits: Callable[[], Iterable[str]]) -> None:
        """Count a rejection; ``culprits`` names its sources, called for sampled ones only."""
        self.counts[cause] = count = self.counts[cause] + 1
        if count <= FULLY_EXPLAINED or count % EXPLANATION_PERIOD == 0:
            weight = 1 if count <= FULLY_EXPLAINED else EXPLANATION_PERIOD
            self._culprits.update({(cause, culprit): weight for culprit in culprits()})

    def shares(self) -> dict[str, dict[str, float]]:
        """Return the fraction of all rejections by cause and source, largest first."""
        total = max(sum(self.counts.values()), 1)
        found: dict[str, dict[str, float]] = {}
        for cause, count in sorted(self.counts.items(), key=lambda item: -item[1]):
            named = {who: n for (why, who), n in self._culprits.most_common() if why == cause}
            sampled = max(sum(named.values()), 1)
            if count:
                found[cause] = {who: count / total * n / sampled for who, n in named.items()}
        return found


class Propagator:
    """Propagates the machine by one step and checks the motion.

    An accepted motion is free between its ends too, as far as the bound on the machine's point
    speeds holds. It is a filter: the verifier alone decides.

    Args:
        problem: Provides machine and world.
        margin: Required clearance from obstacles in [m].
        rejections: Counter to share with other propagators; its own when left out.
        finest: Resolution of the collision check in [m], where the problem's own is coarser.

    Attributes:
        problem: The machine and its world.
        rejections: Counts of rejected motions by cause and source.
        propagations: Steps made so far.
    """

    def __init__(
        self,
        problem: PlanningTask,
        margin: float = 0.0,
        rejections: Rejections | None = None,
        finest: float = math.inf,
    ) -> None:
        self.problem = problem
        self._calls = CompiledStep(problem)
        self._sweep = ContinuousCollisionCheck(problem, self._calls, margin, finest)
        self._limits = [
            (i, float(lower), float(upper))
            for i, (lower, upper) in enumerate(problem.bounds)
            if np.isfinite(lower) or np.isfinite(upper)
        ]
        # Checked in Python; most machines have none.
        self._has_rare_limits = bool(np.isfinite(problem.rate_bounds).any() or problem.keep_outs)
        self.rejections = Rejections() if rejections is None else rejections
        self.propagations = 0

    def step(
        self, x: Sequence[float], u: Sequence[float], duration: float
    ) -> tuple[list[float], bool]:
        """Return the next state and whether the motion to it is free.

        Where the equations of motion are singular the state stays.

        Args:
            x: State, shape (nx,).
            u: Constant inputs, shape (nu,).
            duration: Step length in [s].
        """
        calls = self._calls
        calls.x[:], calls.u[:] = x, u
        self.propagations += 1
        if calls.step(duration):
            self.rejections.add("equations", lambda: ["the step has no result"])
            return list(x), False
        reached = list(calls.next)
        return reached, self._free_on_the_way(duration)

    def touches_nothing(self, x: Sequence[float], u: Sequence[float], duration: float) -> bool:
        """Return whether a step stays in the workspace and is collision-free; state limits aside.

        Args:
            x: State, shape (nx,).
            u: Constant inputs, shape (nu,).
            duration: Step length in [s].
        """
        calls = self._calls
        calls.x[:], calls.u[:] = x, u
        failed = calls.step(duration)
        return not failed and self._sweep.free_within(duration, SAFETY_FACTOR * calls.fastest())

    def is_free(self, x: Sequence[float]) -> bool:
        """Return whether a state is within its limits and collision-free."""
        self._calls.next[:] = x
        return not self._passed() and self._sweep.free()

    def admits(self, x: Sequence[float]) -> bool:
        """Return whether a state is free; count a rejection where it is not."""
        self._calls.next[:] = x
        limit = self._passed()
        if limit:
            self.rejections.add("limit", lambda: [limit])
        elif not self._sweep.free():
            self.rejections.add("collision", self._sweep.rejection_sources)
        else:
            return True
        return False

    def _free_on_the_way(self, duration: float) -> bool:
        """Check the step just made for collisions."""
        limit = (
            self._passed()
            or self._passed_within(duration)
            or ("" if self._calls.keeps_requirements(duration) else "a requirement")
            or self._cone_entered(duration)
        )
        if limit:
            self.rejections.add("limit", lambda: [limit])
            return False
        if not self._sweep.free_within(duration, SAFETY_FACTOR * self._calls.fastest()):
            self.rejections.add("collision", self._sweep.rejection_sources)
            return False
        return True

    def _passed(self) -> str:
        """Return the name of a limit that the state reached violates; empty if none."""
        values = self._calls.next
        for i, lower, upper in self._limits:
            if not lower <= values[i] <= upper:
                return str(self.problem.model.state_names[i])
        if self._has_rare_limits:
            for name, *_ in self.problem.limit_violations(np.array(values)):
                return name
        return ""

    def _passed_within(self, duration: float) -> str:
        """Name a state entry whose extremum within the step violates a limit; empty if none.

        With slopes a and b of opposite sign at the ends of a step h, the extremum exceeds the end
        values by about h/2 |a b| / (|a| + |b|), at most h/2 times the smaller slope.
        """
        before, after = self._calls.slopes()
        for i, lower, upper in self._limits:
            a, b = before[i], after[i]
            if a * b < 0:
                overshoot = SAFETY_FACTOR * 0.5 * duration * min(abs(a), abs(b))
                ends = self._calls.x[i], self._calls.next[i]
                if min(ends) - overshoot < lower or max(ends) + overshoot > upper:
                    return str(self.problem.model.state_names[i])
        return ""

    def _cone_entered(self, duration: float) -> str:
        """Name a keep-out cone violated at samples along the step, ``CONE_RESOLUTION`` apart."""
        problem, calls = self.problem, self._calls
        if not problem.keep_outs:
            return ""
        ends = zip((calls.x, calls.next), calls.slopes(), strict=True)
        fastest = max(_axis_speed(problem, np.array(x), np.array(dx)) for x, dx in ends)
        checks = max(1, math.ceil(SAFETY_FACTOR * fastest * duration / CONE_RESOLUTION))
        for k in range(1, checks + 1):
            calls.step(duration * k / checks)
            poses = problem.frames(np.array(calls.next))
            for cone in problem.keep_outs:
                if cone.angle(poses) < cone.half_angle:
                    return f"the axis of {problem.bodies[cone.body].name}"
        return ""


def _axis_speed(problem: PlanningTask, x: np.ndarray, slope: np.ndarray) -> float:
    """Return the largest angular speed of axes with keep-out cones at a state, in [rad/s]."""
    rates = problem.model.frames_jacobian(x) @ slope
    return max(float(np.linalg.norm(cone.in_world(rates))) for cone in problem.keep_outs)
