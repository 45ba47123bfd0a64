"""Work in a thread that goes on when it is told to, and is waited for."""

from __future__ import annotations

import threading
from contextvars import ContextVar
from typing import Any

import pytest

from kinolab.concurrency.coroutine import Coroutine


def gone_on(coroutine: Coroutine[Any]) -> bool:
    coroutine.resume()
    return coroutine.wait()


def test_work_goes_on_where_it_was_left() -> None:
    seen: list[str] = []

    def work() -> int:
        for k in range(3):
            seen.append(f"work {k}")
            assert not coroutine.suspend()
        return 7

    coroutine: Coroutine[int] = Coroutine(work)
    while not gone_on(coroutine):
        seen.append("other")
    assert seen == ["work 0", "other", "work 1", "other", "work 2", "other"]
    assert coroutine.result == 7


def test_work_that_is_given_up_is_told_so() -> None:
    told, over = [], threading.Event()

    def work() -> None:
        told.append(coroutine.suspend())
        told.append(coroutine.suspend())
        over.set()

    coroutine: Coroutine[None] = Coroutine(work)
    assert not gone_on(coroutine)
    coroutine.close()
    assert over.is_set()  # it was waited for
    assert over.wait(10.0)
    assert told == [True, True]


def test_work_and_its_caller_go_on_at_the_same_time() -> None:
    """Neither would get over the barrier alone."""
    both = threading.Barrier(2)

    def work() -> int:
        both.wait(60.0)
        assert not coroutine.suspend()
        return 7

    coroutine: Coroutine[int] = Coroutine(work)
    coroutine.resume()
    both.wait(60.0)
    assert not coroutine.wait()
    assert gone_on(coroutine)
    assert coroutine.wait()  # again
    assert coroutine.result == 7


def test_work_is_closed_while_it_goes_on() -> None:
    begun, told = threading.Event(), threading.Event()

    def work() -> None:
        begun.set()
        while not coroutine.closed:
            told.wait(0.001)
        assert coroutine.suspend()
        told.set()

    coroutine: Coroutine[None] = Coroutine(work)
    coroutine.resume()
    assert begun.wait(60.0)
    coroutine.close()
    assert told.is_set()


def test_work_that_was_never_resumed_is_not_begun() -> None:
    begun: list[int] = []
    coroutine: Coroutine[None] = Coroutine(lambda: begun.append(1))
    coroutine.close()
    assert coroutine._thread is not None
    coroutine._thread.join(10.0)
    assert not begun


def test_what_the_work_raises_is_raised_by_its_result() -> None:
    coroutine: Coroutine[float] = Coroutine(lambda: 1 / 0)
    assert gone_on(coroutine)
    with pytest.raises(ZeroDivisionError):
        _ = coroutine.result


def test_work_sees_the_context_in_which_it_was_begun() -> None:
    name: ContextVar[str] = ContextVar("name", default="none")
    name.set("mine")
    coroutine: Coroutine[str] = Coroutine(name.get)
    assert gone_on(coroutine)
    assert coroutine.result == "mine"


def test_nobody_else_is_suspended() -> None:
    coroutine: Coroutine[int] = Coroutine(lambda: 1)
    assert not coroutine.suspend()
    assert gone_on(coroutine)


def test_where_there_is_no_thread_the_work_is_done_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    coroutine: Coroutine[int] = Coroutine(lambda: 3 if not coroutine.suspend() else 4)
    assert gone_on(coroutine)
    assert coroutine.result == 3
