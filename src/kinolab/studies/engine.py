"""Engines: they have orders done, on this computer or on a Dask cluster, and give the answers."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from itertools import islice
from pathlib import Path
from typing import Self, TypeAlias, final

from kinolab.concurrency.cancel import CancellationToken, never_cancelled
from kinolab.concurrency.forks import FORKS
from kinolab.concurrency.process_worker import WorkerProcess
from kinolab.errors import KinolabError
from kinolab.studies.orders import Answer, WorkOrder, failure
from kinolab.studies.problem_files import ProblemFiles
from kinolab.studies.worker_process import WorkerLostError, answer_of, work

TRIES = 10  # of one order whose workers are lost


class EngineLostError(KinolabError):
    """The engine has ended while orders were open; those that were answered are not lost."""

    exit_code = 6


class AbstractEngine(ABC):
    """Has orders done by workers; a context manager that ends them.

    Attributes:
        workers: Their number.
        executor: What calls a function elsewhere.
        work: The function that does an order, where it is called.
        hurried: Whether somebody waits for the end, so that ``close`` may not take long.
    """

    workers: int
    executor: Executor
    work: Callable[[WorkOrder], Answer]
    hurried: bool = False

    @abstractmethod
    def close(self) -> None:
        """End all workers, whatever they do."""

    def require(self) -> None:  # noqa: B027  # processes on this computer are always there
        """Make sure that the engine is there.

        Raises:
            EngineLostError: If it is not.
        """

    def lost(self, error: BaseException) -> bool:
        """Whether an order failed only because its worker was lost."""
        return isinstance(error, WorkerLostError)

    @final
    def answers(
        self, orders: Iterator[WorkOrder], stop: CancellationToken = never_cancelled
    ) -> Iterator[Answer]:
        """Yield the answer to each order as it comes, until a token is set.

        Only a few orders per worker are open at a time, so that neither this process nor a
        scheduler needs memory for all. An order whose worker is lost is done again, by another.

        Args:
            orders: Asked for one by one.
            stop: Polled.

        Raises:
            EngineLostError: If the engine has ended.
        """
        open_now = dict[Future[Answer], tuple[WorkOrder, int]]()
        again = deque[tuple[WorkOrder, int]]()
        coming = ((order, 1) for order in orders)
        while not stop():
            self.require()
            # 3 orders per worker that are on their way or done
            room = max(0, 3 * self.workers - len(open_now))
            lost = [again.popleft() for _ in range(min(room, len(again)))]
            for order, tried in [*lost, *islice(coming, room - len(lost))]:
                open_now[self.executor.submit(self.work, order)] = order, tried
            if not open_now:
                return
            # 0.1 [s] between looks at the token
            for future in wait(open_now, 0.1, FIRST_COMPLETED).done:
                order, tried = open_now.pop(future)
                error = WorkerLostError("cancelled") if future.cancelled() else future.exception()
                if error is None:
                    yield future.result()
                elif not self.lost(error):
                    yield failure(order, "crashed", f"{type(error).__name__}: {error}")
                elif tried < TRIES:
                    again.append((order, tried + 1))
                else:
                    yield failure(order, "killed", f"{error}, {TRIES} times.")
        self.hurried = True

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


MakeEngine: TypeAlias = Callable[[Iterable[ProblemFiles], Path], AbstractEngine]
"""Makes an engine, from the files that orders need and a folder for them."""


@final
class LocalEngine(AbstractEngine):
    """Processes on this computer.

    Args:
        root: Folder below which the files of orders are.
    """

    def __init__(self, workers: int, root: Path) -> None:
        self.workers, self._crew = workers, WorkerProcesses(root)
        self.executor = ThreadPoolExecutor(workers, thread_name_prefix="runs")
        self.work = self._crew.answer

    def close(self) -> None:
        """End all workers, whatever they do."""
        self.executor.shutdown(wait=False, cancel_futures=True)
        self._crew.close()
        self.executor.shutdown(wait=True)


class WorkerProcesses:
    """A worker process for each thread that asks for answers; those that are lost are replaced.

    Args:
        root: Folder below which the files of orders are.
    """

    def __init__(self, root: Path) -> None:
        self._root, self._lock = root, threading.Lock()
        self._of_thread: dict[int, WorkerProcess] = {}
        self._closed = False

    def answer(self, order: WorkOrder) -> Answer:
        """Have an order done by the process of this thread.

        Raises:
            WorkerLostError: If it was lost.
        """
        own = threading.get_ident()
        with self._lock:
            if self._closed:
                raise WorkerLostError("the engine is closed")
            if own not in self._of_thread:
                self._of_thread[own] = WorkerProcess(work)
            process = self._of_thread[own]
        try:
            answer = answer_of(process, order, self._root)
        except WorkerLostError:
            self._drop(own, process)
            raise
        if order.isolated and not FORKS:
            self._drop(own, process)
        return answer

    def _drop(self, thread: int, process: WorkerProcess) -> None:
        with self._lock:
            if self._of_thread.get(thread) is process:
                del self._of_thread[thread]
                process.end()

    def close(self) -> None:
        """End all processes."""
        with self._lock:
            self._closed = True
            for process in self._of_thread.values():
                process.end()
            self._of_thread.clear()
