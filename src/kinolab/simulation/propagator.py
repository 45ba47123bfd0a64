"""State propagation with limit and collision checks, and statistics of rejections."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from kinolab.numerics.jit import kernel
from kinolab.numerics.struct import Record
from kinolab.problem import PlanningTask
from kinolab.simulation.collision_context import (
    CollisionContext,
    CollisionScratch,
    clearance_bound,
    collision_context,
    is_motion_free,
    place_machine,
    speed_bound,
)
from kinolab.simulation.limits import (
    KEPT,
    LimitArrays,
    cone_at,
    limit_arrays,
    limit_names,
    passed_at,
    passed_limit,
    slopes_of_step,
)
from kinolab.simulation.machine import Machine, advance, machine_of
from kinolab.world import CollisionChecker

# rejections of each cause that are explained; beyond them one in EXPLANATION_PERIOD
FULLY_EXPLAINED = 200
EXPLANATION_PERIOD = 32
FREE = -1
LIMIT, COLLISION, EQUATIONS = 0, 1, 2  # causes of rejection


class StepChecks(NamedTuple):
    """A machine, its limits and its collision scene, for compiled code."""

    machine: Machine
    limits: LimitArrays
    collision: CollisionContext
    scratch: CollisionScratch


def step_checks(problem: PlanningTask, margin: float = 0.0, finest: float = math.inf) -> StepChecks:
    """Collect what checks of a problem's steps need; the caller must keep the model alive.

    Args:
        problem, margin, finest: As ``collision_context`` takes them.
    """
    scene = collision_context(problem, margin, finest)
    return StepChecks(machine_of(problem), limit_arrays(problem), *scene)


@kernel
def check_step(checks, x, u, after, h, limited):  # type: ignore[no-untyped-def]
    """Make a step and check it.

    Args:
        checks: ``StepChecks``; on collision its ``scratch`` holds the colliding poses.
        x, u: State (nx,) and inputs (nu,).
        after: The state reached, shape (nx,); written.
        h: Step length in [s].
        limited: Whether limits count, beside the workspace's.

    Returns:
        The cause of rejection, or FREE, and the index of the limit that is violated, or KEPT.
    """
    machine, limits, scratch = checks.machine, checks.limits, checks.scratch
    if advance(machine, x, u, h, after) != 0:
        return EQUATIONS, KEPT
    if limited:
        slopes_of_step(machine, limits, x, u, after)
        passed = passed_limit(machine, limits, x, u, after, h, scratch)
        if passed != KEPT:
            return LIMIT, passed
    speed = speed_bound(machine, x, u, scratch)
    clearance, _ = is_motion_free(machine, x, u, after, h, 0.0, speed, scratch, checks.collision)
    return (FREE if clearance >= 0.0 else COLLISION), KEPT


@kernel
def check_state(checks, x):  # type: ignore[no-untyped-def]
    """Check a state (nx,), as ``check_step`` does the one that a step reaches."""
    limits, scratch = checks.limits, checks.scratch
    passed = passed_at(checks.machine, limits, x)
    if passed != KEPT:
        return LIMIT, passed
    place_machine(checks.machine, x, scratch)
    cone = cone_at(limits, scratch)
    if cone != KEPT:
        return LIMIT, x.shape[0] + limits.rate_lower.shape[0] + 1 + cone
    least = checks.collision.required_clearance
    clearance = clearance_bound(least, least, scratch, checks.collision)
    return (FREE if clearance >= least else COLLISION), KEPT


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
        self._model = problem.model  # owns the compiled code
        self._checks = step_checks(problem, margin, finest)
        self._record = Record(self._checks)
        self._x, self._after = np.zeros((2, problem.model.nx))
        self._u = np.zeros(problem.model.nu)
        self.rejections = Rejections() if rejections is None else rejections
        self.propagations = 0
        self.is_free(problem.start.tolist())  # loads compiled code, as what follows
        self.touches_nothing(problem.start.tolist(), problem.model.null_control().tolist(), 0.0)

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
        self.propagations += 1
        cause, limit = self._made(x, u, duration, True)
        if cause == EQUATIONS:
            self.rejections.add("equations", lambda: ["the step has no result"])
            return list(x), False
        return self._after.tolist(), self._counted(cause, limit)

    def touches_nothing(self, x: Sequence[float], u: Sequence[float], duration: float) -> bool:
        """Return whether a step stays in the workspace and is collision-free; state limits aside.

        Args:
            x: State, shape (nx,).
            u: Constant inputs, shape (nu,).
            duration: Step length in [s].
        """
        return bool(self._made(x, u, duration, False)[0] == FREE)

    def is_free(self, x: Sequence[float]) -> bool:
        """Return whether a state is within its limits and collision-free."""
        self._x[:] = x
        return bool(check_state(self._record, self._x)[0] == FREE)

    def admits(self, x: Sequence[float]) -> bool:
        """Return whether a state is free; count a rejection where it is not."""
        self._x[:] = x
        return self._counted(*check_state(self._record, self._x))

    def _made(
        self, x: Sequence[float], u: Sequence[float], duration: float, limited: bool
    ) -> tuple[int, int]:
        """Make a step to ``_after``; return what it is refused for, and which limit it violates."""
        self._x[:], self._u[:] = x, u
        cause: tuple[int, int] = check_step(
            self._record, self._x, self._u, self._after, float(duration), limited
        )
        return cause

    def _counted(self, cause: int, limit: int) -> bool:
        """Count a rejection by its cause; return whether there is none."""
        if cause == LIMIT:
            self.rejections.add("limit", lambda: [limit_names(self.problem)[limit]])
        elif cause == COLLISION:
            self.rejections.add("collision", self._touched)
        return cause == FREE

    @cached_property
    def _checker(self) -> CollisionChecker:
        """Names what comes too close."""
        return self.problem.checker(self._checks.collision.required_clearance)

    def _touched(self) -> list[str]:
        """Name the contacts and limits of the workspace where the last motion was refused."""
        poses, ends = self._checks.scratch.poses, self._checks.scratch.ends
        outside = [
            f"{axis} of {body.name} leaves the workspace"
            for axis, (lower, upper) in self.problem.world.bounds.items()
            for body, row in zip(self.problem.bodies, poses, strict=True)
            if body.moves and not lower <= row["xyz".index(axis) * 4 + 3] <= upper
        ]
        touching = self._checker.contacts(poses, ends)
        return outside + [f"{contact.body} – {contact.obstacle}" for contact in touching]
