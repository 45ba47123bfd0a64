"""Forks answer what this process would answer itself, at once with each other."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

import pytest

from kinolab.concurrency import forks
from kinolab.concurrency.cancel import never_cancelled
from kinolab.concurrency.forks import Fork, answers, can_fork

only_linux = pytest.mark.skipif(sys.platform != "linux", reason="forks are made on Linux alone")


@pytest.fixture(params=["forks", "none"])
def kind(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setattr(forks, "processors", lambda: 2 if request.param == "forks" else 1)
    return str(request.param)


class Sum:
    """Adds up what it is asked, and tells each sum."""

    def __init__(self, first: int) -> None:
        self.sum = first

    def __call__(self, more: int, tell: Callable[[Any], None]) -> tuple[int, int]:
        self.sum += more
        tell(self.sum)
        return self.sum, os.getpid()


def test_answers_depend_on_all_that_was_asked_and_not_on_who_answers(kind: str) -> None:
    told: list[tuple[int, Any]] = []
    both = [Fork(Sum(0)), Fork(Sum(100))]
    sums = []
    for more in (1, 2):
        for fork in both:
            fork.ask(more)
        found = answers(both, lambda k, what: told.append((k, what)), never_cancelled)
        assert found is not None
        sums.append([number for number, _ in found])
    assert sums == [[1, 101], [3, 103]]
    assert [what for k, what in told if k == 0] == [1, 3]
    assert [what for k, what in told if k == 1] == [101, 103]
    processes = {process for _, process in found}
    assert len(processes) == (2 if kind == "forks" and sys.platform == "linux" else 1)
    for fork in both:
        fork.end()


@only_linux
def test_what_a_lost_fork_was_asked_is_answered_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(forks, "processors", lambda: 2)

    def answer(more: int, tell: Callable[[Any], None]) -> int:
        if os.getpid() != here:
            os.kill(os.getpid(), signal.SIGKILL)
        return adding(more, tell)[0]

    here, adding = os.getpid(), Sum(0)
    fork = Fork(answer)
    fork.ask(4)
    assert answers([fork], lambda *_: None, never_cancelled) == [4]
    fork.ask(5)
    assert answers([fork], lambda *_: None, never_cancelled) == [9]


@pytest.mark.usefixtures("kind")
def test_a_failure_is_raised_where_it_was_asked_for() -> None:
    def answer(question: str, _tell: Callable[[Any], None]) -> str:
        raise ValueError(question)

    fork = Fork(answer)
    fork.ask("wrong")
    with pytest.raises(ValueError, match="wrong"):
        answers([fork], lambda *_: None, never_cancelled)
    fork.end()


@only_linux
def test_a_wait_that_is_cancelled_ends_the_forks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(forks, "processors", lambda: 2)

    def sleep(_question: None, tell: Callable[[Any], None]) -> None:
        tell(os.getpid())
        time.sleep(600.0)

    told: list[int] = []
    fork = Fork(sleep)
    fork.ask(None)
    assert answers([fork], lambda _k, process: told.append(process), lambda: bool(told)) is None
    with pytest.raises(ProcessLookupError):
        os.kill(told[0], 0)  # it is gone, and was waited for


@only_linux
def test_other_threads_make_no_forks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(forks, "processors", lambda: 2)
    found: list[bool] = []
    thread = threading.Thread(target=lambda: found.append(can_fork()))
    thread.start()
    thread.join()
    assert (can_fork(), found) == (True, [False])
