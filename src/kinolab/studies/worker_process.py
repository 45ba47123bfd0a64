"""A process that does orders one after the other, each in a fork of its own.

Libraries and the problem are loaded once, before the fork: a run of a hundredth of a second costs a
tenth. The process has no threads when it forks. Where it cannot fork (macOS, whose libraries do not
survive it), every run has a fresh process instead, which loads everything anew.
"""

from __future__ import annotations

import os
import resource
import signal
import time
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path

from kinolab.concurrency.forks import FORKS, forked
from kinolab.concurrency.process_worker import WorkerProcess
from kinolab.studies.hardware import computer
from kinolab.studies.orders import Answer, WorkOrder, failure, peak_memory


class WorkerLostError(Exception):
    """A process has ended before it answered."""


@dataclass(frozen=True)
class Killed:
    """A run that something outside ended, such as a system without memory; it may be repeated."""

    reason: str


def answer_of(worker: WorkerProcess, order: WorkOrder, root: Path) -> Answer:
    """Have a process that runs this module do an order.

    Args:
        root: Folder below which its files are.

    Raises:
        WorkerLostError: If the process, or the run in it, was killed.
    """
    try:
        worker.connection.send((order, root))
        answer: Answer | Killed = worker.connection.recv()
    except (EOFError, OSError) as error:
        raise WorkerLostError("its process has ended") from error
    if isinstance(answer, Killed):
        raise WorkerLostError(answer.reason)
    return answer


def work(connection: Connection) -> None:
    """Do the orders that come by a connection."""
    rehearsed: set[str] = set()
    while True:
        order, root = connection.recv()
        connection.send(_answer(order, root / order.files, connection, rehearsed))


def _answer(
    order: WorkOrder, folder: Path, connection: Connection, rehearsed: set[str]
) -> Answer | Killed:
    try:
        order.prepare(folder)
    except Exception as error:
        return {**computer(), **failure(order, "error", str(error))}
    if FORKS and order.rehearsal and order.files not in rehearsed:
        rehearsed.add(order.files)
        _forked(order.rehearsal, folder, connection)
    load, at = os.getloadavg()[0], time.time()
    if not (order.isolated and FORKS):
        done = order.work(folder)
        memory = peak_memory(resource.getrusage(resource.RUSAGE_SELF))
        answer: Answer | Killed = {**done, "memory": memory}
    else:
        answer = _forked(order, folder, connection)
    if isinstance(answer, Killed):
        return answer
    return {"index": order.index, "began": at, "load": load, **computer(), **answer}


def _forked(order: WorkOrder, folder: Path, connection: Connection) -> Answer | Killed:
    """Do an order in a fork, which is killed at its limits, or once nobody waits for it."""
    child, ours = forked(lambda theirs: theirs.send(order.work(folder)))
    answer, exceeded = None, ""
    with ours:
        while True:
            # 0.05 [s] between looks at a run that has limits
            ready = wait(
                [ours, connection], 0.05 if order.cpu_limit or order.memory_limit else None
            )
            if ours in ready:
                with suppress(EOFError, OSError):
                    answer = ours.recv()
                break
            if connection in ready:  # no further order comes before this one is answered
                os.kill(child, signal.SIGKILL)
                os._exit(1)
            if exceeded := _exceeded(order, child):
                os.kill(child, signal.SIGKILL)
                break
    _, status, usage = os.wait4(child, 0)
    used = {"cpu": usage.ru_utime + usage.ru_stime, "memory": peak_memory(usage)}
    if exceeded:
        return {
            **failure(order, exceeded, f"it was ended at its {exceeded.replace('_', ' ')}."),
            **used,
        }
    if answer is not None:
        return {**answer, "memory": used["memory"]}
    if os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGKILL:
        return Killed("its process was killed, as happens where memory runs out")
    how = signal.Signals(os.WTERMSIG(status)).name if os.WIFSIGNALED(status) else "its own exit"
    return {**failure(order, "crashed", f"its process was ended by {how}."), **used}


def _exceeded(order: WorkOrder, child: int) -> str:
    """Return the limit that a process has exceeded; empty if it has not."""
    import psutil

    with suppress(psutil.Error):
        process = psutil.Process(child)
        with process.oneshot():
            times, memory = process.cpu_times(), process.memory_info().rss / 1e6
        if order.cpu_limit is not None and times.user + times.system > order.cpu_limit:
            return "cpu_limit"
        if order.memory_limit is not None and memory > order.memory_limit:
            return "memory_limit"
    return ""
