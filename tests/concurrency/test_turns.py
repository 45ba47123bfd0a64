"""Two workers of whom only one works at any time."""

from __future__ import annotations

import threading
from contextvars import ContextVar

import pytest

from kinolab.concurrency.turns import Turns


def test_work_goes_on_where_it_was_left() -> None:
    seen: list[str] = []

    def work() -> int:
        for k in range(3):
            seen.append(f"work {k}")
            assert not turns.pause()
        return 7

    turns: Turns[int] = Turns(work)
    while not turns.advance():
        seen.append("other")
    assert seen == ["work 0", "other", "work 1", "other", "work 2", "other"]
    assert turns.result == 7


def test_work_that_is_given_up_is_told_so() -> None:
    told, over = [], threading.Event()

    def work() -> None:
        told.append(turns.pause())
        told.append(turns.pause())
        over.set()

    turns: Turns[None] = Turns(work)
    assert not turns.advance()
    turns.close()
    assert over.wait(10.0)
    assert told == [True, True]


def test_work_that_never_had_a_turn_is_not_begun() -> None:
    begun: list[int] = []
    turns: Turns[None] = Turns(lambda: begun.append(1))
    turns.close()
    assert turns._thread is not None
    turns._thread.join(10.0)
    assert not begun


def test_what_the_work_raises_is_raised_by_its_result() -> None:
    turns: Turns[float] = Turns(lambda: 1 / 0)
    assert turns.advance()
    with pytest.raises(ZeroDivisionError):
        _ = turns.result


def test_work_sees_the_context_in_which_it_was_begun() -> None:
    name: ContextVar[str] = ContextVar("name", default="none")
    name.set("mine")
    turns: Turns[str] = Turns(name.get)
    assert turns.advance()
    assert turns.result == "mine"


def test_a_pause_of_anybody_else_is_none() -> None:
    turns: Turns[int] = Turns(lambda: 1)
    assert not turns.pause()
    assert turns.advance()


def test_where_there_is_no_thread_the_work_is_done_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    turns: Turns[int] = Turns(lambda: 3 if not turns.pause() else 4)
    assert turns.advance()
    assert turns.result == 3
