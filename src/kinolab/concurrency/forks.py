"""Forks of this process, which do at once what this one would do in turn.

A fork knows all that this process knew when it was made, so that nothing has to be sent to it but
what it is asked, and nothing but answers comes back. What it answers does not depend on whether
there are forks at all: where there are none (one processor, another thread than the main one, or
macOS, whose libraries do not survive them), or where one is lost, this process does it itself.

Source: Conway, A multiprocessor system design, AFIPS Fall Joint Computer Conference, 1963 (fork and
join).
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from typing import Any, Generic, TypeVar

from kinolab.concurrency.cancel import CancellationToken
from kinolab.concurrency.parent_death import end_with_parent
from kinolab.concurrency.processors import processors

A = TypeVar("A")

Telling = Callable[[Any], None]
FORKS = sys.platform == "linux"  # macOS's libraries do not survive it

_running: set[Fork[Any]] = set()


def can_fork() -> bool:
    """Say whether forks of this process would do more than it does itself."""
    main = threading.current_thread() is threading.main_thread()
    return FORKS and main and processors() > 1


class Fork(Generic[A]):
    """A fork of this process, or this process itself.

    Args:
        answer: Gets what is asked and a function that tells this process something at once.
        alone: Whether nothing is done at the same time, so that a fork would be of no use.
    """

    def __init__(self, answer: Callable[[Any, Telling], A], *, alone: bool = False) -> None:
        self._answer = answer
        self._asked: list[Any] = []
        self._answered = 0  # of these, in this process
        self._pid = 0
        self.connection: Connection | None = None
        if not alone and can_fork():
            with suppress(OSError):
                self._begin()

    def ask(self, question: Any) -> None:
        """Ask something, which a fork begins to work on at once."""
        self._asked.append(question)
        if self.connection is not None:
            try:
                self.connection.send(question)
            except OSError:
                self.end()

    def answer_here(self, tell: Telling) -> A:
        """Answer in this process what was asked last, and what led to it if a fork was lost."""
        questions, self._answered = self._asked[self._answered :], len(self._asked)
        return [self._answer(question, tell) for question in questions][-1]

    def end(self) -> None:
        """End the fork, whatever it does; what is asked is answered here from now on."""
        if self.connection is not None:
            _running.discard(self)
            os.kill(self._pid, signal.SIGKILL)
            os.waitpid(self._pid, 0)
            self.connection.close()
            self.connection = None

    def _begin(self) -> None:
        self._pid, self.connection = forked(self._serve)
        _running.add(self)

    def _serve(self, connection: Connection) -> None:
        """Answer questions in a fork until it is killed; a failure is left to who asked."""
        while True:
            question = connection.recv()
            told = self._answer(question, lambda told: connection.send((False, told)))
            connection.send((True, told))


def forked(work: Callable[[Connection], None]) -> tuple[int, Connection]:
    """Do some work in a fork, which gets one end of a connection and ends with this process.

    Returns the fork's number, and the other end.

    Raises:
        OSError: If the system cannot start another process.
    """
    ours, theirs = Pipe()
    parent = os.getpid()
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    try:
        with theirs, warnings.catch_warnings():
            # Other threads hold no lock that the work needs: what it calls is not theirs.
            warnings.simplefilter("ignore", DeprecationWarning)
            pid = os.fork()
            if not pid:
                try:
                    signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever made it decides
                    signal.signal(signal.SIGTERM, signal.SIG_DFL)
                    signal.pthread_sigmask(signal.SIG_SETMASK, mask)
                    end_with_parent()
                    if os.getppid() == parent:  # it may be gone already
                        work(theirs)
                finally:
                    os._exit(0)  # this is a copy of a process that goes on
    except OSError:
        ours.close()
        raise
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
    return pid, ours


def kill_all() -> None:
    """Kill all forks, for exits that skip the usual clean-up."""
    for fork in tuple(_running):
        fork.end()


def answers(
    forks: Sequence[Fork[A]], tell: Callable[[int, Any], None], cancelled: CancellationToken
) -> list[A] | None:
    """Wait for the answers to what forks were asked last.

    Args:
        forks: Each was asked one thing.
        tell: Gets the index of a fork and what it tells on the way, in whatever order that comes.
        cancelled: Asked now and then.

    Returns:
        In the order of the forks; None where the wait was cancelled, which ends all of them.
    """
    if cancelled():
        return None
    waiting = {fork.connection: k for k, fork in enumerate(forks) if fork.connection is not None}
    heard: dict[int, A] = {}
    while waiting:
        if cancelled():
            for fork in forks:
                fork.end()
            return None
        for connection in wait(list(waiting), 0.05):  # [s] between looks at the cancellation token
            assert isinstance(connection, Connection)
            try:
                done, what = connection.recv()
            except (EOFError, OSError):  # killed, as happens where memory runs out
                forks[waiting.pop(connection)].end()
                continue
            if done:
                heard[waiting.pop(connection)] = what
            else:
                tell(waiting[connection], what)
    return [
        heard[k] if k in heard else fork.answer_here(partial(tell, k))
        for k, fork in enumerate(forks)
    ]
