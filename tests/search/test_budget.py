"""Budgets: what counts, and when no more may be used up."""

from __future__ import annotations

import math

import pytest

from kinolab.search import Budget


def test_preparation_does_not_count_whenever_it_is_made() -> None:
    now = 0.0
    budget = Budget(10.0, clock=lambda: now)
    now = 3.0
    budget.restart()
    now = 5.0
    with budget.preparing():
        now = 50.0
    assert (budget.elapsed, budget.prepared, budget.expired()) == (2.0, 48.0, False)
    now = 58.5
    assert (budget.elapsed, budget.expired()) == (10.5, True)


def test_an_iteration_that_is_begun_may_be_finished_and_no_other_may_begin() -> None:
    budget = Budget(10.0, max_iterations=2, clock=lambda: 0.0)
    assert not budget.spent()
    budget.take_back()
    assert not budget.spent()
    assert not budget.spent()
    assert (budget.iterations, budget.over, budget.expired()) == (2, True, False)
    assert budget.spent()
    budget.end()
    assert budget.expired()


@pytest.mark.parametrize(
    ("taken", "compiled", "late"),
    [(100.0, 0.0, True), (100.0, 95.0, False), (20.0, 0.0, False), (36.0, 0.0, True)],
)
def test_a_world_that_takes_much_longer_to_build_than_the_limit_leaves_no_time(
    taken: float, compiled: float, late: bool
) -> None:
    """Half a minute to load things is free, and so is compiling, which happens once."""
    now = [0.0]
    budget = Budget(5.0, clock=lambda: now[0], compiled=lambda: compiled)
    now[0] = taken
    budget.restart()
    assert budget.expired() is late
    assert budget.prepared == taken


def test_a_fraction_is_spent_when_its_time_or_its_number_is() -> None:
    now = 0.0
    time = Budget(10.0, clock=lambda: now)
    half = time.fraction(0.5)
    assert half() == 0.0
    now = 4.0
    assert half() == pytest.approx(0.8)
    now = 10.1
    assert half() == math.inf
    assert time.over
    number = Budget(math.inf, 4)
    assert [number.fraction()() for _ in range(4)] == [0.25, pytest.approx(1 / 3), 0.5, 1.0]
    assert number.over
    assert Budget(3.0, 4, started=0.0, clock=lambda: 3.1).over
    assert Budget(1.0, cancelled=lambda: True).over


def test_what_is_cancelled_is_expired_whatever_is_left() -> None:
    cancelled = False
    budget = Budget(math.inf, cancelled=lambda: cancelled)
    assert not budget.expired()
    cancelled = True
    assert budget.expired()
    assert budget.spent()
    assert budget.iterations == 0
