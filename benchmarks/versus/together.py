"""Two searches at once against one: in threads of one process, and in processes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from . import workers
from .growing import GROWER

NODES, ROUNDS = 20_000, 10  # of a tree, and how often it grows
WAYS = {"one": (1, 1), "two threads": (1, 2), "two processes": (2, 1)}  # processes, threads of each


@dataclass(frozen=True)
class Throughput:
    """How much was done at once.

    Attributes:
        problem: Its name.
        way: One of ``WAYS``.
        rate: Propagations per second on the clock, of all searches together.
    """

    problem: str
    way: str
    rate: float

    def __str__(self) -> str:
        return f"{self.problem}, {self.way}: {self.rate:.0f} propagations/s"


def run_together(problems: Sequence[str], repeats: int) -> Iterator[Throughput]:
    """Yield what was done, one way after the other."""
    for problem in problems:
        for _ in range(repeats):
            for way, (processes, threads) in WAYS.items():
                yield Throughput(problem, way, _rate(problem, processes, threads))


def _rate(problem: str, processes: int, threads: int) -> float:
    given = (problem, GROWER, NODES, ROUNDS, threads)
    started = [workers.start("abreast", *given) for _ in range(processes)]
    try:
        for worker in started:
            assert worker.stdout is not None
            worker.stdout.readline()  # it is ready
        for worker in started:
            assert worker.stdin is not None
            worker.stdin.write(workers.GO)
            worker.stdin.flush()
        answers = [workers.answer(worker) for worker in started]
    finally:
        for worker in started:
            worker.kill()
    seconds = max(a["end"] for a in answers) - min(a["begin"] for a in answers)
    return float(sum(a["propagations"] for a in answers) / seconds)
