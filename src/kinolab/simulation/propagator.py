"""Moves a machine by one step, judges the motion by FCL along it, and counts what is refused."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.simulation.compiled_step import CompiledStep
from kinolab.simulation.continuous_collision import SAFETY_FACTOR, ContinuousCollisionCheck

CONE_RESOLUTION = 0.01  # [rad] of an axis between two looks at a forbidden cone
# rejections of each cause whose culprit is looked for; beyond them one in SPARSE
FULLY_EXPLAINED = 200
EXPLANATION_PERIOD = 32


class Rejections:
    """How many motions were refused, by cause, and who is to blame.

    Naming a culprit can cost more than the motion did, so that only a sample is asked for: every
    one of the first ones, then one in ``EXPLANATION_PERIOD``, which counts for as many.

    Attributes:
        counts: Refused motions by cause: ``limit``, ``collision`` or ``equations``.
    """

    def __init__(self) -> None:
        self.counts = {"limit": 0, "collision": 0, "equations": 0}
        self._culprits: Counter[tuple[str, str]] = Counter()

    def add(self, cause: str, culprits: Callable[[], Iterable[str]]) -> None:
        """Count a rejection; ``culprits`` names who is to blame, where it is asked."""
        self.counts[cause] = count = self.counts[cause] + 1
        if count <= FULLY_EXPLAINED or count % EXPLANATION_PERIOD == 0:
            weight = 1 if count <= FULLY_EXPLAINED else EXPLANATION_PERIOD
            self._culprits.update({(cause, culprit): weight for culprit in culprits()})

    def shares(self) -> dict[str, dict[str, float]]:
        """Return by cause and culprit the share of all rejections, the largest first."""
        total = max(sum(self.counts.values()), 1)
        found: dict[str, dict[str, float]] = {}
        for cause, count in sorted(self.counts.items(), key=lambda item: -item[1]):
            named = {who: n for (why, who), n in self._culprits.most_common() if why == cause}
            sampled = max(sum(named.values()), 1)
            if count:
                found[cause] = {who: count / total * n / sampled for who, n in named.items()}
        return found


class Propagator:
    """Moves the machine by one step and judges the motion.

    What is accepted is free between its ends too, as far as the bound on the speed of the
    machine's points holds. It is a filter: the verifier alone decides.

    Args:
        problem: Whose machine and world.
        margin: Room in [m] that is asked for beside obstacles.
        rejections: Where to count, if not apart from other propagators.

    Attributes:
        problem: The machine and its world.
        rejections: How many motions were refused, by cause and culprit.
    """

    def __init__(
        self, problem: PlanningTask, margin: float = 0.0, rejections: Rejections | None = None
    ) -> None:
        self.problem = problem
        self._calls = CompiledStep(problem)
        self._sweep = ContinuousCollisionCheck(problem, self._calls, margin)
        self._limits = [
            (i, float(lower), float(upper))
            for i, (lower, upper) in enumerate(problem.bounds)
            if np.isfinite(lower) or np.isfinite(upper)
        ]
        # These are checked in Python; most machines have none of them.
        self._has_rare_limits = bool(np.isfinite(problem.rate_bounds).any() or problem.keep_outs)
        self.rejections = Rejections() if rejections is None else rejections

    def step(
        self, x: Sequence[float], u: Sequence[float], duration: float
    ) -> tuple[list[float], bool]:
        """Return where a step leads, and whether the way there is free.

        Where the equations of motion cannot be solved the machine stays.

        Args:
            x: State, shape (nx,).
            u: Inputs held, shape (nu,).
            duration: In [s].
        """
        calls = self._calls
        calls.x[:], calls.u[:] = x, u
        if calls.step(duration):
            self.rejections.add("equations", lambda: ["the step has no result"])
            return list(x), False
        reached = list(calls.next)
        return reached, self._free_on_the_way(duration)

    def touches_nothing(self, x: Sequence[float], u: Sequence[float], duration: float) -> bool:
        """Say whether a step stays inside the workspace and touches nothing; limits do not count.

        Args:
            x: State, shape (nx,).
            u: Inputs held, shape (nu,).
            duration: In [s].
        """
        calls = self._calls
        calls.x[:], calls.u[:] = x, u
        failed = calls.step(duration)
        return not failed and self._sweep.free_within(duration, SAFETY_FACTOR * calls.fastest())

    def is_free(self, x: Sequence[float]) -> bool:
        """Say whether a state is within its limits and touches nothing."""
        self._calls.next[:] = x
        return not self._passed() and self._sweep.free()

    def admits(self, x: Sequence[float]) -> bool:
        """Say whether a state is free, and count it as refused where it is not."""
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
        """Check the step just made."""
        limit = (
            self._passed()
            or self._passed_within(duration)
            or self._requirement_missed(duration)
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
        """Return the name of a limit that the state reached passes; empty if it passes none."""
        values = self._calls.next
        for i, lower, upper in self._limits:
            if not lower <= values[i] <= upper:
                return str(self.problem.model.state_names[i])
        if self._has_rare_limits:
            for name, *_ in self.problem.limit_violations(np.array(values)):
                return name
        return ""

    def _passed_within(self, duration: float) -> str:
        """Name a state that turns back within the step and has its extreme beyond a limit.

        With slopes of opposite sign a and b at the ends of a step h, the extreme passes the ends
        by about h/2 |a b| / (|a| + |b|), at most h/2 of the smaller slope.
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

    def _requirement_missed(self, duration: float) -> str:
        return "" if self._calls.keeps_requirements(duration) else "a requirement"

    def _cone_entered(self, duration: float) -> str:
        """Check forbidden cones so often along the step that no axis turns far in between."""
        for poses in self._looks_at_axes(duration):
            for cone in self.problem.keep_outs:
                if cone.angle(poses) < cone.half_angle:
                    return f"the axis of {self.problem.bodies[cone.body].name}"
        return ""

    def _looks_at_axes(self, duration: float) -> Iterator[np.ndarray]:
        """Yield the bodies' poses along the step just made, where cones are forbidden."""
        if not self.problem.keep_outs:
            return
        calls = self._calls
        ends = zip((calls.x, calls.next), calls.slopes(), strict=True)
        fastest = max(_axis_speed(self.problem, np.array(x), np.array(dx)) for x, dx in ends)
        checks = max(1, math.ceil(SAFETY_FACTOR * fastest * duration / CONE_RESOLUTION))
        for k in range(1, checks + 1):
            calls.step(duration * k / checks)
            yield self.problem.frames(np.array(calls.next))


def _axis_speed(problem: PlanningTask, x: np.ndarray, slope: np.ndarray) -> float:
    """Return how fast the fastest axis with a forbidden cone turns at a state, in [rad/s]."""
    rates = problem.model.frames_jacobian(x) @ slope
    return max(float(np.linalg.norm(cone.in_world(rates))) for cone in problem.keep_outs)
