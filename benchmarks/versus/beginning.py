"""How long it takes to the first node: nothing compiled yet, another machine, everything there."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from . import workers

STATES = ("nothing compiled", "new machine", "everything compiled")


@dataclass(frozen=True)
class Beginning:
    """From definition to the first node, in [s].

    Attributes:
        problem, planner: Their names.
        state: One of ``STATES``: what was on disk.
        imports: Before the definition.
        machine: Until its equations are derived and compiled, or read.
        search: From there to the first node.
    """

    problem: str
    planner: str
    state: str
    imports: float
    machine: float
    search: float

    @property
    def total(self) -> float:
        """From definition to the first node."""
        return self.machine + self.search

    def __str__(self) -> str:
        return f"{self.problem}, {self.planner}, {self.state}: {self.total:.2f} s"


def begin(problems: Sequence[str], planners: Sequence[str], repeats: int) -> Iterator[Beginning]:
    """Yield how long it took, in processes of their own; only the first comes without repeats."""
    for problem in problems:
        for planner in planners:
            with tempfile.TemporaryDirectory() as kernels, tempfile.TemporaryDirectory() as kept:
                yield _begin(problem, planner, STATES[0], kernels, kept)
                for _ in range(repeats):
                    with tempfile.TemporaryDirectory() as nothing:
                        yield _begin(problem, planner, STATES[1], kernels, nothing)
                    yield _begin(problem, planner, STATES[2], kernels, kept)


def _begin(problem: str, planner: str, state: str, kernels: str, machines: str) -> Beginning:
    folders = {"NUMBA_CACHE_DIR": kernels, "KINOLAB_CACHE": machines}
    worker = workers.start("first_node", problem, planner, **folders)
    return Beginning(problem, planner, state, **workers.answer(worker))
