"""What an engine has done for it: one run of a study, or a batch of executions of a plan."""

from __future__ import annotations

import hashlib
import json
import math
import resource
import sys
import tempfile
import time
import traceback
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar

from kinolab.errors import KinolabError
from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.studies.problem_files import SCENARIO

Answer = dict[str, Any]


@dataclass(frozen=True)
class WorkOrder(ABC):
    """Work for a process.

    Attributes:
        index: Its place among all.
        files: Key of the files that it needs.
        cpu_limit: Processor time in [s] at which its process is ended; None for no limit.
        memory_limit: Memory in [MB] at which its process is ended; None for no limit.
    """

    index: int
    files: str
    cpu_limit: float | None = field(default=None, kw_only=True)
    memory_limit: float | None = field(default=None, kw_only=True)

    isolated: ClassVar[bool] = True  # whether it has a process of its own, with limits

    @property
    def rehearsal(self) -> WorkOrder | None:
        """A short order that has all loops compiled, done once before others are timed."""
        return None

    @abstractmethod
    def prepare(self, folder: Path) -> None:
        """Do what several orders have in common, in the process that is there for all of them."""

    @abstractmethod
    def work(self, folder: Path) -> Answer:
        """Return the answer, as plain data."""


@dataclass(frozen=True)
class SearchOrder(WorkOrder):
    """One search, verified.

    Attributes:
        seed: Of the random numbers.
        overrides: As of ``--set``.
        improve: Whether the motion is made exact and shorter.
        check: Whether it is re-checked from its files.
        search: Processor time of the search in [s]; the scenario's limit when None.
        iterations: Of the search; the scenario's limit when None.
    """

    seed: int
    overrides: tuple[str, ...] = ()
    improve: bool = False
    check: bool = False
    search: float | None = None
    iterations: int | None = None

    @property
    def rehearsal(self) -> WorkOrder | None:
        """A search of one iteration; it, too, ends where its planner heeds no limit."""
        # 60.0 [s] of processor time in which all loops of a planner are compiled
        cpu = None if self.cpu_limit is None else max(self.cpu_limit, 60.0)
        return replace(self, iterations=1, improve=False, check=False, cpu_limit=cpu)

    def prepare(self, folder: Path) -> None:
        """Load the problem."""
        _problem(folder, self.overrides)

    def work(self, folder: Path) -> Answer:
        """Search, verify, and return what a row says of it."""
        begun, problem = (time.perf_counter(), time.process_time()), None
        try:
            problem = _problem(folder, self.overrides)
            told = self._searched(problem)
        except MemoryError:
            told = {"status": "out_of_memory", "message": "it ran out of memory."}
        except KinolabError as error:
            told = {"status": "error", "message": str(error)}
        except Exception:
            told = {"status": "crashed", "message": traceback.format_exc(limit=-3)}
        ended = time.perf_counter(), time.process_time()
        if problem and told["status"] == "solved":
            from kinolab.verification.lower_bound import duration_bound

            told["duration_bound"] = duration_bound(problem).seconds
        return {**told, "wall": ended[0] - begun[0], "cpu": ended[1] - begun[1]}

    def _searched(self, problem: PlanningTask) -> Answer:
        from kinolab.solve import solve

        searched: list[float] = []

        def watch(budget: Budget) -> None:
            """Count processor time, so that a busy computer searches as far as an idle one."""
            if budget.clock is time.monotonic:  # others count work
                before = time.monotonic() - time.process_time()
                budget.clock = lambda: before + time.process_time()
                budget.stage = lambda stage: note(stage, budget)

        def note(stage: str, budget: Budget) -> None:
            if stage == "simulate":
                searched.append(budget.elapsed)

        plan = solve(
            problem,
            seed=self.seed,
            time_limit=self.search,
            max_iterations=self.iterations,
            optimize=self.improve,
            improve=None if self.improve else 0.0,
            watch=watch,
        )
        found, motion = plan.improvements, plan.trajectory
        margin = plan.certificate.margin if plan.certificate else None
        digest = hashlib.sha256()
        for array in () if motion is None else (motion.t, motion.x, motion.u):
            digest.update(array.tobytes())
        return {
            "status": plan.status,
            "message": plan.message,
            "iterations": plan.iterations,
            "duration": plan.duration,
            "first_duration": found[0].duration if found else plan.duration,
            "goal_distance": plan.goal_distance if math.isfinite(plan.goal_distance) else None,
            "clearance": margin.clearance + margin.required if margin else None,
            "steps": None if motion is None else len(motion.u),
            "motion": None if motion is None else digest.hexdigest()[:32],
            "checked": self._checked(problem, plan) if self.check else None,
            "statistics": json.dumps(plan.statistics, sort_keys=True),
            "search": searched[0] if searched else None,
            "prepare": plan.timings.get("prepare"),
            "verify": plan.timings.get("verify"),
            "improvements": [[one.after, one.duration] for one in found],
        }

    def _checked(self, problem: PlanningTask, plan: Any) -> bool | None:
        """Write the files of the run and check it from these alone; None without a solution."""
        from kinolab.runs import check_run, write_run

        if plan.status != "solved":
            return None
        with tempfile.TemporaryDirectory() as folder:
            write_run(Path(folder), problem, plan)
            return check_run(Path(folder)).passed


@lru_cache(maxsize=4)  # by each process, so that the seeds of one need not load it again
def _problem(folder: Path, overrides: tuple[str, ...]) -> PlanningTask:
    from kinolab.loading import load

    return load(folder / SCENARIO, overrides=overrides)


def peak_memory(usage: resource.struct_rusage) -> float:
    """Return the largest memory of a process that has ended, in MB."""
    return usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024) / 1e6


def failure(order: WorkOrder, status: str, message: str) -> Answer:
    """Return the answer of an order that gave none."""
    return {"index": order.index, "status": status, "message": message}


def as_told(answer: Mapping[str, Any]) -> Answer:
    """Return an answer without what is not finite, which JSON and tables do not have."""
    return {
        key: None if isinstance(value, float) and not math.isfinite(value) else value
        for key, value in answer.items()
    }
