"""Improvement has two lines of work: at once with two processors, in turn with one."""

from __future__ import annotations

import sys

import pytest

import kinolab
from kinolab.concurrency import forks
from kinolab.solve import PlanResult
from tests.planners.test_planners import bits


@pytest.mark.parametrize("seed", [1, 2])
def test_one_processor_gives_the_same_bits_as_two(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = 0
    begin = forks.Fork._begin

    def counted(fork: forks.Fork[object]) -> None:
        nonlocal made
        made += 1
        begin(fork)

    def plan(processors: int) -> PlanResult:
        monkeypatch.setattr(forks, "processors", lambda: processors)
        return kinolab.load("rolling_disk_maze").solve(seed=seed, improve=1.0)

    monkeypatch.setattr(forks.Fork, "_begin", counted)
    one = plan(1)
    assert made == 0
    two = plan(2)
    assert made > 0 or sys.platform != "linux"
    assert bits(one) == bits(two)
    assert one.cost is not None
    assert one.cost < one.statistics["raw_duration"]
