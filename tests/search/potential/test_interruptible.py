"""Work beside the main thread: its result, its failure, and an end at once where one is asked."""

from __future__ import annotations

import threading

import pytest

from kinolab.search.potential.interruptible import run_unless_cancelled
from tests.support import within


def test_the_result_is_returned() -> None:
    assert run_unless_cancelled(lambda: 42, lambda: False) == 42


def test_a_failure_is_raised_here() -> None:
    def fail() -> None:
        raise ValueError("no way")

    with pytest.raises(ValueError, match="no way"):
        run_unless_cancelled(fail, lambda: False)


def test_work_that_never_ends_is_given_up() -> None:
    gate = threading.Event()
    with within(60):
        assert run_unless_cancelled(gate.wait, lambda: True) is None
    gate.set()
