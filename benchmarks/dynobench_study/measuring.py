"""All runs, each in a process of its own, several at a time; what ends is written at once."""

from __future__ import annotations

import json
import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Protocol

from .problems import environment, machine_of
from .records import Offline, Run, run_of

GRACE = 120.0  # [s] for imports, compilation and both judgements, beyond the limit of the search
REPEATS = 3  # of what is measured offline
ONE_CORE = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")


class Ended(Protocol):
    """A process that has ended; ``code`` is None where it was killed at its limit."""

    code: int | None
    stdout: str
    stderr: str


Start = Callable[[Sequence[str], float], Ended]


class Processes(Protocol):
    """Starts processes, several at a time, and ends all of them at once."""

    def run(self, command: Sequence[str], limit: float) -> Ended:
        """Run a command; kill it after a limit in [s]."""

    def close(self) -> None:
        """Kill what runs and start nothing any more."""


@dataclass(frozen=True)
class Task:
    """One problem with one seed."""

    problem: str
    seed: int


def prepare_environment() -> None:
    """Let processes find this package and kinolab, and use one core each."""
    os.environ.update(ONE_CORE, PYTHONPATH=os.pathsep.join(filter(None, sys.path)))


def measure(
    processes: Processes, folder: Path, tasks: Sequence[Task], limit: float,
    planner: str | None, jobs: int,
) -> Iterator[Run]:  # fmt: skip
    """Yield runs as they end; whoever stops asking ends what still runs.

    Args:
        processes: To start them with.
        folder: Of the environments.
        tasks: What to run.
        limit: Of each search in [s].
        planner: Its name; the usual one where None.
        jobs: Processes at a time.
    """
    with ThreadPoolExecutor(jobs) as pool:
        futures = [pool.submit(one, processes.run, folder, task, limit, planner) for task in tasks]
        try:
            for future in as_completed(futures):
                yield future.result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
            processes.close()


def one(start: Start, folder: Path, task: Task, limit: float, planner: str | None) -> Run:
    """Make one run in a process of its own."""
    file, chosen = environment(folder, task.problem), [planner] if planner else []
    arguments = [str(file), task.problem, str(task.seed), str(limit), *chosen]
    command = [sys.executable, "-m", "dynobench_study.worker", *arguments]
    ended = start(command, limit + GRACE)
    if ended.code == 0:
        return run_of(json.loads(ended.stdout.splitlines()[-1]))
    last = ended.stderr.strip().rpartition("\n")[2]
    how = f"killed after {limit + GRACE:g} s" if ended.code is None else f"exit {ended.code}"
    return Run(task.problem, task.seed, complaint=f"{how} {last}".strip())


def measure_offline(start: Start, folder: Path, problems: Sequence[str]) -> Iterator[Offline]:
    """Yield what each machine costs with nothing kept, one after the other."""
    for machine, problem in {machine_of(name): name for name in reversed(problems)}.items():
        yield Offline(machine, tuple(_cold(start, environment(folder, problem), REPEATS)))


def _cold(start: Start, file: Path, repeats: int) -> Iterator[float]:
    code = "import os, runpy, sys; os.environ['KINOLAB_CACHE'] = sys.argv.pop(1); "
    code += "runpy.run_module('dynobench_study.offline', run_name='__main__', alter_sys=True)"
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as empty:
            ended = start([sys.executable, "-c", code, empty, str(file)], GRACE)
        if ended.code == 0:
            yield float(ended.stdout.splitlines()[-1])


def offline_sentence(offline: Sequence[Offline]) -> str:
    """Return the largest median."""
    medians = [median(one.seconds) for one in offline if one.seconds]
    return f"Offline at most {max(medians):.2f} s for a machine." if medians else ""
