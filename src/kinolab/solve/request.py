"""What is asked of everyone who searches: with which planner and seeds, and how long."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from kinolab import planners
from kinolab.problem import Problem
from kinolab.search import AbstractPlanner
from kinolab.search.plugins import full_reference


@dataclass(frozen=True)
class Request:
    """Which searches to make, one after the other.

    Attributes:
        planner: Name of the planner; None for the scenario's.
        settings: Of the planner, over the scenario's.
        seed: Of the first search.
        stride: From one seed to the next.
        time_limit: Of all searches of one process or thread together, in [s].
        max_iterations: Of each search, None for no limit.
        anytime: Whether to go on with further seeds until the time is over.
        optimize: Whether to make exact and shorten what is found.
    """

    planner: str | None
    settings: dict[str, Any] = field(default_factory=dict)
    seed: int = 1
    stride: int = 1
    time_limit: float = 30.0
    max_iterations: int | None = None
    anytime: bool = False
    optimize: bool = True

    def seeds(self) -> Iterator[int]:
        """Yield the seeds to try."""
        return count(self.seed, self.stride) if self.anytime else iter((self.seed,))

    def split(self, jobs: int) -> Iterator[Request]:
        """Yield what each of several at once does, so that none tries a seed of another's."""
        for k in range(jobs):
            yield replace(self, seed=self.seed + k, stride=jobs)


def make_planner(problem: Problem, name: str | None, settings: dict[str, Any]) -> AbstractPlanner:
    """Return a planner with the scenario's settings, overridden by those given here.

    The scenario's settings are those of the planner that it names: another one has its own.

    Raises:
        InputError: If the planner or a setting does not exist.
    """
    section = problem.scenario.planner
    own = full_reference(section.name, problem.scenario.folder)
    chosen = own if name is None else full_reference(name, Path.cwd())
    inherited = section.settings if chosen == own else {}
    return planners.make(chosen, {**inherited, **settings})


def stream(seed: int, k: int) -> int:
    """Return the seed of the k-th further search after one with a seed."""
    return int(np.random.SeedSequence((seed, k)).generate_state(1)[0])
