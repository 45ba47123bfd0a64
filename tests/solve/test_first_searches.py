"""Searches before anything is improved: a detour is not improved while a shorter way is known."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab import trajopt
from kinolab.concurrency.cancel import never_cancelled
from kinolab.numerics.work import WorkClock, charge, counted_work
from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.solve import make_planner
from kinolab.solve.improve import (
    FIRST_SEARCHES,
    RACE_FRACTION,
    RACE_SECONDS_PER_STEP,
    Incumbent,
    PlanImprover,
    Shortening,
)
from kinolab.solve.plan import Request
from kinolab.trajectory import Trajectory
from tests.support import OPEN, problem_of

STICKY = "system.parameters.mu=10"  # a rim that never limits the motion


def test_a_maze_is_not_gone_through_by_the_first_detour() -> None:
    """The first search goes 20 s; one of the next finds a way about half as long, improved then."""
    problem = kinolab.load("rolling_disk_maze", overrides=[STICKY])
    plan = problem.solve(seed=1)
    first, other, *_ = [one.duration for one in plan.improvements if one.by == "repair"]
    assert other < 0.6 * first
    assert plan.trajectory.duration < other
    assert 1 <= plan.statistics["further_searches"] <= FIRST_SEARCHES + 10


def test_the_summary_says_when_more_improvement_would_pay() -> None:
    plan = kinolab.load("rolling_disk_maze", overrides=[STICKY]).solve(seed=1, improve=0.4)
    assert plan.statistics["improvement_unfinished"] == 1.0
    used = r"all 0\.4 s for improving it were used(, and the second half .*)?; "
    assert re.search(f"{used}--set planner.improve=2", str(plan))


# --- two ways ---

STEPS = 400
SLOW, QUICK = 0.99, 0.7  # factors by which motions get shorter, each in so many seconds of work:
TURN = 0.1


def standing(problem: PlanningTask, duration: float) -> Trajectory:
    """Return a motion that stays at the start."""
    model, t = problem.model, np.linspace(0.0, duration, STEPS + 1)
    x = np.tile(problem.start, (len(t), 1))
    u = np.zeros((STEPS, model.nu))
    return Trajectory(t, x, u, model.state_names, model.control_names)


@dataclass
class Race:
    """Two motions of which the longer one gets shorter sooner."""

    problem: PlanningTask
    clock: WorkClock
    given: list[Trajectory]
    turns: Counter[int]

    def winner(self, work: float) -> Shortening | None:
        """Return who wins with so many seconds of work."""
        plan = self.problem.solve("rrt_fast", seed=1, optimize=False)
        asked = Request(None, time_limit=100.0)
        improver = PlanImprover(self.problem, make_planner(self.problem, None, {}), asked, float)
        improver._incumbent = Incumbent(
            self.problem, replace(plan, trajectory=self.given[0]), Budget(100.0), float
        )
        remaining = Budget(work, clock=lambda: self.clock.seconds)
        return improver._most_promising(self.given, remaining)


@pytest.fixture
def race(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Race]:
    problem = problem_of(tmp_path, OPEN)
    shorter, longer = standing(problem, 10.0), standing(problem, 11.0)
    turns: Counter[int] = Counter()

    def shortened(
        problem: PlanningTask, given: Trajectory, spent: Callable[[], float]
    ) -> Iterator[Trajectory]:
        factor, duration = SLOW if given is shorter else QUICK, given.duration
        while spent() < 1.0:
            charge(TURN)
            turns[id(given)] += 1
            duration *= factor
            yield standing(problem, duration)

    monkeypatch.setattr(trajopt, "shortened", shortened)
    monkeypatch.setattr(Incumbent, "take", lambda *_: True)
    with counted_work() as clock:
        yield Race(problem, clock, [shorter, longer], turns)


def test_of_two_ways_the_one_goes_on_that_gets_shorter(race: Race) -> None:
    """How long motions are at first does not decide; the winner's work is not made twice."""
    shorter, longer = race.given
    won = race.winner(6.0)
    assert won is not None
    assert won.given is longer
    share = round(RACE_FRACTION * 6.0 / TURN)
    assert race.turns[id(shorter)] == pytest.approx(share, abs=1)
    assert race.turns[id(longer)] == pytest.approx(share, abs=1)
    assert won.best.duration == pytest.approx(11.0 * QUICK ** race.turns[id(longer)])
    won.until(never_cancelled)
    assert race.clock.seconds == pytest.approx(6.0, abs=2 * TURN)  # all of it, and no more


def test_with_little_work_one_motion_is_shortened_alone(race: Race) -> None:
    steps = race.given[0].duration / race.problem.step
    assert race.winner(0.9 * RACE_SECONDS_PER_STEP * steps / RACE_FRACTION) is None
    assert not race.turns
