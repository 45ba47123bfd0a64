"""Clearance at a state and smallest clearance along a motion, with the closest pairs."""

from __future__ import annotations

import math
from dataclasses import dataclass

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.verification.clearance_search import ClearanceSearch
from kinolab.world import CollisionChecker

CONTACT_MARGIN = 1e-5  # [m] beyond the clearance, to find the closest pairs by contact
CLEARANCE_TOLERANCE = 1e-4  # [m] by which the minimum may be missed between two samples
TIME_DIGITS = 4  # of a time in [s] that is shown
RELATIVE_TOLERANCE = 0.01  # of the smallest clearance: the same, where that is larger
BETWEEN = " – "  # the names of a pair
MAX_CHECKS = 20_000  # samples after which the tolerance doubles, and so on


@dataclass(frozen=True)
class StateClearance:
    """The clearance at a state.

    Attributes:
        clearance: How far every point may move, in [m]; infinite if there are no obstacles.
        beside: The closest pairs of body and obstacle.
    """

    clearance: float
    beside: tuple[str, ...]

    def __str__(self) -> str:
        return f"{100 * self.clearance:.2g} cm ({', '.join(self.beside)})"


@dataclass(frozen=True)
class ClearanceMargin:
    """The smallest clearance along a motion.

    Attributes:
        clearance: How far every point may move, in [m], before anything can touch, or come nearer
            to an obstacle than ``required``.
        time: When it occurs, in [s].
        beside: The closest pairs of body and obstacle, or of two bodies.
        required: The distance in [m] that ``[world] clearance`` keeps from that obstacle; 0 from
            the ground, and between bodies.
    """

    clearance: float
    time: float
    beside: tuple[str, ...]
    required: float = 0.0

    def __str__(self) -> str:
        beside = f" ({', '.join(self.beside)})" if self.beside else ""
        whole = f"smallest clearance {_length(self.clearance + self.required)}"
        if self.required:
            whole += f", {_length(self.clearance)} more than [world] clearance asks for,"
        return f"{whole} at t = {round(self.time, TIME_DIGITS):.6g} s{beside}"


def _length(metres: float) -> str:
    return f"{metres:.3g} m" if metres >= 1.0 else f"{1000 * metres:.3g} mm"


def state_clearance(problem: PlanningTask, x: Array, checker: CollisionChecker) -> StateClearance:
    """Return the clearance at a state (nx,); 0 if it collides."""
    place = problem.placement(x)
    clearance = checker.clearance(*place)
    if math.isinf(clearance):
        return StateClearance(clearance, ())
    reaching = checker.inflated(clearance + CONTACT_MARGIN, ground=problem.world.ground)
    pairs = (f"{contact.body}{BETWEEN}{contact.obstacle}" for contact in reaching.contacts(*place))
    return StateClearance(clearance, tuple(dict.fromkeys(pairs)))


def least_clearance(search: ClearanceSearch) -> ClearanceMargin | None:
    """Return the smallest clearance along a motion; None if there is nothing to collide with.

    The true minimum is smaller by at most ``CLEARANCE_TOLERANCE`` or ``RELATIVE_TOLERANCE``,
    provided that the speed bound holds. The ground has a search of its own: the height of a machine
    changes more slowly than its place, or not at all.

    Args:
        search: Of everything that can be touched, as far as a verdict needed it.

    Raises:
        TooFastError: If the motion is too fast to be sampled.
    """
    dense, problem = search.dense, search.dense.problem
    if problem.world.ground and not all(body.touches_ground for body in problem.bodies):
        ground = ClearanceSearch(dense, problem.ground_checker(), search.told)
        ground.sample_slopes()
        _settle(ground, math.inf)
        alone = problem.checker().inflated(0.0, ground=False)
        free = ClearanceSearch(dense, alone, search.told)
        _settle(free, ground.least)
        nearest = min(ground, free, key=lambda one: one.least)
    else:
        nearest = search
        _settle(nearest, math.inf)
    if not math.isfinite(nearest.least):
        return None
    nearest.pinpoint()
    beside = state_clearance(problem, nearest.x, problem.checker()).beside
    obstacles = {obstacle.name for obstacle in problem.world.obstacles}
    kept = any(pair.rpartition(BETWEEN)[2] in obstacles for pair in beside)
    required = problem.world.clearance if kept else 0.0
    return ClearanceMargin(nearest.least, nearest.time, beside, required)


def _settle(search: ClearanceSearch, known: float) -> None:
    """Search until there is nowhere noticeably less clearance than the smallest, or is known."""

    def below() -> float:
        least = min(search.least, known)
        if not math.isfinite(least):
            return -math.inf
        coarser = 2.0 ** (search.count // MAX_CHECKS)
        return least - coarser * max(CLEARANCE_TOLERANCE, RELATIVE_TOLERANCE * least)

    search.narrow(below, "the smallest clearance")
