"""How fast trees grow as they become large, and what their nodes take of memory: both sides."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from . import workers
from .cpp import Baseline
from .runs import KINOLAB, LIKE, OMPL, Entrant

SIZES = (2000, 10_000, 20_000, 40_000)  # nodes
GROWER = "rrt_fast"
LAZY = {"MALLOC_MMAP_THRESHOLD_": "65536"}  # large arrays take memory where they are written to


@dataclass(frozen=True)
class Growth:
    """A tree that grew toward a goal that cannot be reached.

    Attributes:
        problem: Its name.
        entrant: Who grew it.
        seed: Of the random numbers.
        rates: Propagations per second of CPU time, up to each of ``SIZES`` from the one before.
        megabytes: Growth of the resident memory per 1000 nodes from the first of them to the last.
    """

    problem: str
    entrant: Entrant
    seed: int
    rates: tuple[float, ...]
    megabytes: float

    def __str__(self) -> str:
        rates = " ".join(f"{rate:.0f}" for rate in self.rates)
        return f"{self.problem}, {self.entrant}, seed {self.seed}: {rates} propagations/s"


def grow(baseline: Baseline, problems: list[str], seeds: range, limit: float) -> Iterator[Growth]:
    """Yield how trees grew, OMPL's and kinolab's in turn."""
    like = LIKE[GROWER]
    for seed in seeds:
        for problem in problems:
            report = baseline.report(problem, like, seed, limit, SIZES)
            yield growth(problem, Entrant(OMPL, like), seed, report["marks"])
            worker = workers.start("grow", problem, GROWER, seed, limit, *SIZES, **LAZY)
            marks = workers.answer(worker)["marks"]
            yield growth(problem, Entrant(KINOLAB, GROWER, like), seed, marks)


def growth(problem: str, entrant: Entrant, seed: int, marks: list[dict[str, float]]) -> Growth:
    """Return what marks at one node and at ``SIZES`` say; a tree that stayed smaller has fewer."""
    rates = tuple(
        (after["propagations"] - before["propagations"]) / (after["cpu"] - before["cpu"])
        for before, after in pairwise(marks)
    )
    first, last = marks[min(1, len(marks) - 1)], marks[-1]
    nodes = max(last["nodes"] - first["nodes"], 1)
    megabytes = 1000 * (last["resident"] - first["resident"]) / nodes
    return Growth(problem, entrant, seed, rates, megabytes)
