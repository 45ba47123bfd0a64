"""Clearance at a state and smallest clearance along a motion, with the closest pairs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from operator import itemgetter

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.verification.between_samples.clearance_search import ClearanceSearch
from kinolab.world import CollisionChecker

CLEARANCE_TOLERANCE = 1e-4  # [m] by which the minimum may be missed between two samples
TIME_DIGITS = 4  # of a time in [s] that is shown
RELATIVE_TOLERANCE = 0.01  # of the smallest clearance: the same, where that is larger
BETWEEN = " – "  # the names of a pair


@dataclass(frozen=True)
class StateClearance:
    """The clearance at a state.

    Attributes:
        clearance: The distance in [m], beyond what the world asks for; infinite if there is
            nothing to touch.
        beside: The closest pairs of body and obstacle, or of two bodies.
    """

    clearance: float
    beside: tuple[str, ...]

    def __str__(self) -> str:
        return f"{100 * self.clearance:.2g} cm ({', '.join(self.beside)})"


@dataclass(frozen=True)
class ClearanceMargin:
    """The smallest clearance along a motion.

    Attributes:
        clearance: The distance between the two that come closest, in [m], less ``required``.
        time: When it occurs, in [s].
        beside: The closest pairs of body and obstacle, or of two bodies.
        required: The distance in [m] that ``[world] clearance`` keeps from that obstacle, whether
            it stands or moves; 0 from the ground, and between bodies.
    """

    clearance: float
    time: float
    beside: tuple[str, ...]
    required: float = 0.0

    def __str__(self) -> str:
        beside = f" ({', '.join(self.beside)})" if self.beside else ""
        whole = f"smallest clearance {shown_length(self.clearance + self.required)}"
        if self.required:
            whole += f", {shown_length(self.clearance)} more than [world] clearance asks for,"
        return f"{whole} at t = {round(self.time, TIME_DIGITS):.6g} s{beside}"


def shown_length(metres: float) -> str:
    """Return a length in [m] in words, below a metre in millimetres."""
    return f"{metres:.3g} m" if metres >= 1.0 else f"{1000 * metres:.3g} mm"


def state_clearance(problem: PlanningTask, x: Array, checker: CollisionChecker) -> StateClearance:
    """Return the clearance at a state (nx,); 0 if it collides."""
    place = problem.placement(x)
    kinds = [(moving * part.clearance(*place), moving, part) for part, moving in _kinds(checker)]
    clearance, moving, nearest = min(kinds, key=itemgetter(0))
    if math.isinf(clearance):
        return StateClearance(clearance, ())
    # [m] beyond the clearance, to find the closest pairs by contact
    reaching = nearest.inflated(clearance / moving + 1e-5, ground=nearest.scene.ground)
    pairs = (f"{contact.body}{BETWEEN}{contact.obstacle}" for contact in reaching.contacts(*place))
    return StateClearance(clearance, tuple(dict.fromkeys(pairs)))


def _kinds(checker: CollisionChecker) -> list[tuple[CollisionChecker, int]]:
    """Return checkers of what can be touched, and how many of two that touch can move."""
    if not len(checker.scene.own_pairs):
        return [(checker, 1)]
    return [(checker.without_pairs(), 1), (checker.of_pairs(), 2)]


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
    ground = problem.world.ground and not all(body.touches_ground for body in problem.bodies)
    checker = problem.checker().inflated(0.0, ground=problem.world.ground and not ground)
    searches, least, kinds = list[tuple[float, ClearanceSearch]](), math.inf, _kinds(checker)
    for part, moving in [(problem.ground_checker(), 1), *kinds] if ground else kinds:
        whole = not ground and len(kinds) == 1
        one = search if whole else ClearanceSearch(dense, part, search.told)
        if ground and not searches:
            one.sample_slopes()
        _settle(one, least / moving)
        searches.append((moving * one.least, one))
        least = min(least, moving * one.least)
    if not math.isfinite(least):
        return None
    nearest = min(searches, key=itemgetter(0))[1]
    nearest.pinpoint()
    beside = state_clearance(problem, nearest.x, nearest.checker)
    obstacles = {obstacle.name for obstacle in problem.world.obstacles}
    obstacles |= {body.name for body in problem.bodies if body.prescribed}
    kept = any(obstacles.intersection(pair.split(BETWEEN)) for pair in beside.beside)
    required = problem.world.clearance if kept else 0.0
    return ClearanceMargin(beside.clearance, nearest.time, beside.beside, required)


def _settle(search: ClearanceSearch, known: float) -> None:
    """Search until there is nowhere noticeably less clearance than the smallest, or is known."""

    def below() -> float:
        least = min(search.least, known)
        if not math.isfinite(least):
            return -math.inf
        # samples after which the tolerance doubles, and so on
        coarser = 2.0 ** (search.count // 20_000)
        return least - coarser * max(CLEARANCE_TOLERANCE, RELATIVE_TOLERANCE * least)

    search.narrow(below, "the smallest clearance")
