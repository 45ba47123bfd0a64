"""Parallel searches, each with its own seeds.

They run in threads if the planner releases the GIL while it searches, in processes otherwise: OMPL
holds it.
"""

from __future__ import annotations

import pickle
import time
from collections.abc import Callable, Iterable
from multiprocessing.connection import wait

from kinolab.errors import KinolabError
from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.solve.jobs import INTERRUPTED, AbstractJob, ProcessJob, ThreadJob
from kinolab.solve.plan import Attempt, Listeners, Request
from kinolab.solve.solution_pool import SolutionPool
from kinolab.solve.worker import OUT_OF_MEMORY

REQUEST_SECONDS = 0.25  # [s] for a search to end on request


class JobsError(KinolabError):
    """No search of several completed; ``.attempts`` says how each ended."""

    def __init__(self, attempts: Iterable[Attempt], exit_code: int) -> None:
        self.attempts, self.exit_code = tuple(attempts), exit_code
        super().__init__("\n".join(f"seed {a.seed}: {a.detail}" for a in self.attempts))


def solve_at_once(
    problem: PlanningTask,
    request: Request,
    pool: SolutionPool,
    in_threads: bool,
    listeners: Listeners,
) -> None:
    """Run ``request.jobs`` searches in parallel until one has a plan or all have ended.

    Raises:
        InputError: If this platform cannot start such processes.
        JobsError: If the searches cannot be started, or none of them completed.
    """
    budget = Budget(request.time_limit)
    if listeners.watch:
        listeners.watch(budget)
    team = _Team(pool, request)
    try:
        team.start(problem, in_threads)
        team.listen(budget, listeners.progress)
    finally:
        team.close()
    if pool.best is None and not budget.interrupted:
        raise JobsError(pool.all, team.exit_code)


class _Team:
    """Owns the processes or threads, from the first start to the last exit."""

    def __init__(self, pool: SolutionPool, request: Request) -> None:
        self._pool, self._request = pool, request
        self._jobs: list[AbstractJob] = []

    @property
    def exit_code(self) -> int:
        """Exit code if all have failed: the first failure's."""
        return next((job.failure for job in self._jobs if job.failure), OUT_OF_MEMORY)

    def start(self, problem: PlanningTask, in_threads: bool) -> None:
        """Start all of them.

        Raises:
            JobsError: If one of them cannot be started.
        """
        parcel = b"" if in_threads else pickle.dumps(problem)
        for part in self._request.split():
            try:
                if in_threads:
                    self._jobs.append(ThreadJob(problem, part, self._pool))
                else:
                    self._jobs.append(ProcessJob(parcel, part, self._pool))
            except OSError as error:
                kind = "thread" if in_threads else "process"
                what = f"its {kind} cannot be started ({error}). Ask for fewer."
                failed = Attempt(part.seed, "failed", 0, detail=what)
                raise JobsError([failed], OUT_OF_MEMORY) from error

    def listen(self, budget: Budget, progress: Callable[[int, float], None] | None) -> None:
        """Process messages until one has won, all have ended, or an interrupt times out."""
        ending = _Ending()
        while self._running and not self._won and not ending.reached:
            # [s] between checks for an interrupt by the user
            ready = wait([job.connection for job in self._running], 0.05)
            for job in self._running:
                if job.connection in ready and not (self._won or job.over):
                    job.hear()
                    for other in self._running if self._solved else ():
                        if other is not job:  # which improves its plan alone
                            other.drop(self._reason)
            if budget.interrupted:
                ending.press(self._running)
            elif progress and (seconds := max(job.seconds for job in self._jobs)):
                progress(sum(job.iterations for job in self._jobs), seconds)

    def close(self) -> None:
        """Kill what still runs."""
        reason = self._reason
        for job in self._jobs:
            job.kill()
        for job in self._jobs:
            job.close(reason)

    @property
    def _running(self) -> list[AbstractJob]:
        return [job for job in self._jobs if not job.over]

    @property
    def _reason(self) -> str:
        best = self._pool.best
        return f"seed {best.seed} had won." if self._solved and best else INTERRUPTED

    @property
    def _solved(self) -> bool:
        """Whether one has a sufficient plan."""
        best = self._pool.best
        return not self._request.anytime and best is not None and best.status == "solved"

    @property
    def _won(self) -> bool:
        """Whether that one has also finished."""
        best = self._pool.best
        return self._solved and any(best and a.seed == best.seed for a in self._pool.attempts)


class _Ending:
    """Escalating shutdown of searches, complete well within a second.

    Attributes:
        reached: Whether the grace period for their results is over.
    """

    def __init__(self) -> None:
        self.reached = False
        self._begun = 0.0
        self._calls = 0

    def press(self, jobs: Iterable[AbstractJob]) -> None:
        """Request an end, abort stages or give up, whichever is due."""
        now = time.monotonic()
        self._begun = self._begun or now
        due = 2 if now > self._begun + REQUEST_SECONDS else 1
        if self._calls < due:
            self._calls = due
            for job in jobs:
                job.end_search()
        # [s] more to abort the current stage
        self.reached = now > self._begun + REQUEST_SECONDS + 0.2
