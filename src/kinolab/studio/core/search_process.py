"""A search in a process of its own, watched while it runs: a crash ends it, and not the studio."""

from __future__ import annotations

import pickle
import re
import signal
import threading
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from typing import Any

from kinolab.concurrency.process_worker import WorkerProcess, leave_with
from kinolab.errors import KinolabError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.solve import PlanResult
from kinolab.trajectory import Trajectory

SET = re.compile(r"--set (\S+=\S+)")  # a change as the diagnosis words it
Hear = Callable[[Any], None]


@dataclass(frozen=True)
class Told:
    """What is being done, in words."""

    words: str


@dataclass(frozen=True, eq=False)
class Explored:
    """The search graph so far, as segments of the leading body, shape (edges, 2, 3), in [m]."""

    segments: Array


@dataclass(frozen=True)
class Improved:
    """A verified plan that is better than those before."""

    plan: PlanResult


@dataclass(frozen=True)
class Ended:
    """How the search ended.

    Attributes:
        plan: What came of it; None where it failed.
        sentences: Why nothing was found.
        changes: Changes that let a short search succeed, as ``--set`` takes them.
        failure: Why it failed, in words.
    """

    plan: PlanResult | None = None
    sentences: tuple[str, ...] = ()
    changes: tuple[str, ...] = field(default=())
    failure: str = ""


def search(connection: Connection) -> None:
    """Search as the studio asks by a connection, and send it messages, in a process of its own."""
    parcel, guess, seconds = connection.recv()
    leave_with(connection)
    try:
        _search(connection, pickle.loads(parcel), guess, seconds)
    except KinolabError as error:
        connection.send(Ended(failure=str(error)))
    except MemoryError:
        connection.send(Ended(failure="The search ran out of memory."))
    except (BrokenPipeError, ConnectionResetError):
        raise
    except Exception:
        connection.send(Ended(failure=traceback.format_exc(limit=-3)))


def _search(
    connection: Connection, problem: PlanningTask, guess: Trajectory | None, improve: float | None
) -> None:
    from kinolab.analyze.diagnose import diagnose
    from kinolab.show.scene.scenes import branches
    from kinolab.solve import solve

    asked_to_end = threading.Event()

    def progress(iterations: int, seconds: float) -> None:
        connection.send(Told(f"{iterations} iterations in {seconds:.1f} s"))

    def watch(budget: Any) -> None:
        def end(*_: Any) -> None:
            asked_to_end.set()
            budget.end()

        signal.signal(signal.SIGTERM, end)
        budget.viewer = lambda graph: connection.send(Explored(branches(problem, graph)))
        budget.told = lambda words: connection.send(Told(words))
        if asked_to_end.is_set():
            budget.end()

    plan = solve(
        problem,
        guess=guess,
        improve=improve,
        progress=progress,
        watch=watch,
        improved=lambda plan: connection.send(Improved(plan)),
    )
    if plan.graph is not None:
        connection.send(Explored(branches(problem, plan.graph)))
    if plan.status == "solved" or asked_to_end.is_set():
        connection.send(Ended(plan))
        return
    connection.send(Told("looking for the reason"))
    found = diagnose(problem, plan, progress=lambda words: connection.send(Told(words)))
    changes = [
        SET.findall(trial.words)[0]
        for trial in found.retries
        if trial.solved and SET.search(trial.words)
    ]
    connection.send(Ended(plan, tuple(found.sentences), tuple(changes)))


class SearchProcess:
    """A search that is running.

    Args:
        problem: To be solved.
        hear: Called with each message in a thread of its own; the last one is ``Ended``.
        guess: A motion that is tried first.
        improve: Work on making it shorter, in [s]; the scenario's when left out.

    Attributes:
        process: In which it searches.
    """

    def __init__(
        self,
        problem: PlanningTask,
        hear: Hear,
        guess: Trajectory | None = None,
        improve: float | None = None,
    ) -> None:
        self._worker = WorkerProcess(search)
        self.process = self._worker.process
        self._worker.post((pickle.dumps(problem), guess, improve))
        self._hear, self._asked = hear, False
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def end(self) -> None:
        """Ask it to end with the best so far; asked again, it ends at once."""
        if self._asked:
            self.process.kill()
        else:
            self.process.terminate()
        self._asked = True

    def close(self) -> None:
        """End it, whatever it does."""
        self.process.kill()
        self._thread.join()

    def _listen(self) -> None:
        try:
            while True:
                message = self._worker.connection.recv()
                self._hear(message)
                if isinstance(message, Ended):
                    break
        except (EOFError, OSError):
            self._hear(Ended(failure=self._ending()))
        finally:
            self._worker.end()

    def _ending(self) -> str:
        code = self.process.wait()
        if self._asked:
            return "The search was stopped."
        how = signal.Signals(-code).name if code < 0 else f"exit code {code}"
        return f"The search crashed ({how}). The studio goes on; the scenario is as it was."
