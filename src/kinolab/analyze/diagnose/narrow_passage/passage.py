"""By how much is a passage too narrow? Geometric path searches with shrunk machines.

Source: Hsu, Kavraki, Latombe, Motwani, Sorkin, On finding narrow passages with probabilistic
roadmap planners, WAFR 1998, where the free space is dilated and a path then pushed back into it.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from kinolab.analyze.diagnose.narrow_passage.configuration_path import (
    Configurations,
    SearchEffort,
    find_path,
)
from kinolab.analyze.diagnose.narrow_passage.motion_per_coordinate import motion_per_coordinate
from kinolab.analyze.diagnose.narrow_passage.path_deformation import PathDeformation
from kinolab.analyze.diagnose.narrow_passage.path_widening import (
    RESOLUTION,
    SHRINKAGE_QUANTUM,
    PathWidening,
    RequiredShrinkage,
)
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask

SLIMMER = {80: 1, 320: 6, 1280: 6}  # searches by quanta of shrinkage per side: 2, 8 and 32 cm
SLIMMEST = max(SLIMMER)
MAX_CHECKS = 40_000  # collision checks per path search
ROUGH, FINE = (0.016, 12), (0.008, 150)  # spacing in [m] and patience of widening
KNOWN_TO = 1e-3  # [m]: no width is stated more finely
SIDES = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]


@dataclass(frozen=True)
class Passage:
    """Result of the geometric path search.

    Attributes:
        open: Whether a path was found for the machine as it is.
        narrow_by: How much narrower a machine passes, in [m]: by how much the passage is too
            narrow. None if it is open, or if no path was found even for the smallest machine.
        beside: The pairs of body and obstacle that block it, if it is too narrow.
        finished: Whether there was time for all searches; otherwise a path may have been missed,
            and less than ``narrow_by`` may suffice.
        at_most: Whether less than ``narrow_by`` may suffice, because a body that blocks it is too
            thin to become so much narrower.
        without: The obstacles that move, which are left out: a way at all times says nothing.
    """

    open: bool
    narrow_by: float | None = None
    beside: tuple[str, ...] = ()
    finished: bool = True
    at_most: bool = False
    without: tuple[str, ...] = ()

    @property
    def blocked(self) -> bool:
        """Whether geometry keeps the machine from the goal."""
        return self.finished and not self.open

    @property
    def sentence(self) -> str:
        """Whether the machine's shape passes, and if not, by how much."""
        if self.open:
            aside = " and what moves" if self.without else ""
            moving = f" ({', '.join(self.without)})" if self.without else ""
            return f"Its dynamics{aside}{moving} aside, there is a way from the start to the goal."
        if self.narrow_by is None:
            narrower = f" even for a machine {200 * SLIMMEST * SHRINKAGE_QUANTUM:g} cm narrower"
            missing = narrower if self.finished else " in time, its dynamics aside"
            return f"No way was found{missing}."
        width, beside = _width(self.narrow_by), ", ".join(self.beside)
        if self.finished:
            figure = "at most" if self.at_most or self.narrow_by < KNOWN_TO else "about"
            return f"The way is {figure} {width} too narrow: {beside}."
        return f"No way was found in time, but one for a machine {width} narrower: {beside}."


def is_applicable(problem: PlanningTask) -> bool:
    """Whether the search applies: there is something to collide with, and no closed loop."""
    touchable = bool(problem.world.obstacles or problem.system.collisions)
    return touchable and not problem.machine.closes_loops


def find_passage(
    problem: PlanningTask,
    goals: Sequence[Array],
    seconds: float,
    say: Callable[[str], None] = lambda _: None,
) -> Passage:
    """Search for a path of the machine as it is, then of shrunk ones.

    Args:
        goals: States of the goal region, shape (nx,) each.
        seconds: Processor time of this thread after which no further search starts, so that a
            computer with other work finds as much as an idle one.
        say: Receives progress messages.
    """
    search = _Search(problem, goals, seconds)
    say("looking for a way for its shape alone")
    if search.path(0, 1) is not None:
        return Passage(open=True)
    paths: list[tuple[Array, int]] = []
    for slim, seeds_tried in SLIMMER.items():
        if len(paths) < 3:  # paths after which no smaller machine is tried
            say(f"looking for a way for its shape, {200 * slim * SHRINKAGE_QUANTUM:g} cm narrower")
            paths += search.paths(slim, seeds_tried)
    if not paths:
        return Passage(open=False, finished=not search.expired())
    say("squeezing the machine through")
    # Five are widened: a shrunk machine may pass where a larger one never does
    path, slim = search.widened(paths[:5])
    if slim == 0:
        return Passage(open=True)
    tight = search.tight(path, slim)
    lack = SHRINKAGE_QUANTUM * (slim if search.is_one_sided(tight, slim) else 2 * slim)
    beside = search.touched(tight, slim)
    at_most = not search.is_exact(slim, beside)
    return Passage(False, lack, beside, not search.expired(), at_most)


class _Search:
    """Path searches with shrunk machines in one problem."""

    def __init__(self, problem: PlanningTask, goals: Sequence[Array], seconds: float) -> None:
        self._end = time.thread_time() + seconds
        far = motion_per_coordinate(problem, [problem.start, *goals[:4]])
        self._fit = RequiredShrinkage(problem)
        self._bands = PathDeformation(problem, far)
        self._squeeze = PathWidening(self._bands, self._fit, self.expired)
        # 0.03 [m] of motion between two collision checks, before the fine check
        self._space = Configurations(problem, far, 0.03)
        self._start = np.clip(problem.start, *problem.bounds.T).tolist()
        free = [x.tolist() for x in goals if self._fit.fits(x, 0)]
        self._goals = free or [x.tolist() for x in goals]

    def expired(self) -> bool:
        """Whether no further search should start."""
        return time.thread_time() > self._end

    def path(self, slim: int, seed: int) -> Array | None:
        """Search for a path of a machine shrunk by ``slim`` quanta, and check it finely."""
        effort = SearchEffort(MAX_CHECKS, self._end - time.thread_time())
        shape = self._fit.shape(slim)
        path = find_path(self._space, shape, self._start, self._goals, effort, seed)
        if path is None or self._fit.blocked(self._bands.filled(path, RESOLUTION), slim).any():
            return None
        return path

    def paths(self, slim: int, seeds_tried: int) -> list[tuple[Array, int]]:
        """Search with several seeds for paths of such a machine."""
        seeds = range(1, seeds_tried + 1)
        found = (self.path(slim, seed) for seed in seeds if not self.expired())
        return [(path, slim) for path in found if path is not None]

    def widened(self, paths: Sequence[tuple[Array, int]]) -> tuple[Array, int]:
        """Widen paths coarsely, then finely the one that fits the largest machine."""
        rough = []
        for path, slim in paths:
            rough.append(self._squeeze.widened(path, slim, *ROUGH))
            if rough[-1][1] == 0 or self.expired():
                break
        path, slim = min(rough, key=lambda found: found[1])
        return self._squeeze.widened(path, slim, *FINE)

    def tight(self, path: Array, slim: int) -> Array:
        """Return the states of a path (n, nx) at which a machine one quantum larger collides."""
        blocked = self._fit.blocked(path, slim - 1)
        return path[blocked]

    def is_one_sided(self, tight: Array, slim: int) -> bool:
        """Whether half the shrinkage suffices after a translation, as at a low gate."""
        shape, by = self._fit.shape((slim + 1) // 2), (slim + 1) // 2 * SHRINKAGE_QUANTUM
        return any(not any(shape.collides(x, by * side) for x in tight.tolist()) for side in SIDES)

    def is_exact(self, slim: int, pairs: Sequence[str]) -> bool:
        """Whether the bodies that touch something are narrower by all of the shrinkage."""
        return self._fit.is_exact(slim, {pair.partition(" – ")[0] for pair in pairs})

    def touched(self, tight: Array, slim: int) -> tuple[str, ...]:
        """Name what a slightly too large machine touches on a path, most frequent first."""
        # 8 quanta by which the machine is enlarged to find what blocks it
        shape, counts = self._fit.shape(max(slim - 8, 0)), Counter[str]()
        for x in tight.tolist():
            counts.update(shape.touches(x))
        return tuple(pair for pair, _ in counts.most_common())


def _width(length: float) -> str:
    """Format a length in [m] to its known precision."""
    if length > 0.0075:
        return f"{round(200 * length) / 2:g} cm"
    return f"{1000 * max(length, KNOWN_TO):.0f} mm"
