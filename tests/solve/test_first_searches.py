"""Searches before anything is improved: a detour is not improved while a shorter way is known."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab import trajopt
from kinolab.concurrency import forks
from kinolab.numerics.work import WorkClock, charge, counted_work
from kinolab.problem import PlanningTask
from kinolab.scenario import Effort
from kinolab.search import Budget
from kinolab.solve import improve, make_planner
from kinolab.solve.improve import SEARCHES_PER_WAY, PlanImprover, _expected_gain
from kinolab.solve.incumbent import Incumbent
from kinolab.solve.plan import Request
from kinolab.solve.refinement import RefinedWay
from kinolab.solve.starts import Start, Starts
from kinolab.trajectory import Trajectory
from tests.support import OPEN, problem_of

STICKY = "system.parameters.mu=10"  # a rim that never limits the motion


def test_a_maze_is_not_gone_through_by_the_first_detour() -> None:
    """The first search goes 20 s; one of the next finds a way about half as long, improved then."""
    problem = kinolab.load("rolling_disk_maze", overrides=[STICKY])
    plan = problem.solve(seed=1, planner="kpiece_fast")
    first, other, *_ = [one.duration for one in plan.improvements if one.by == "repair"]
    assert other < 0.6 * first
    assert plan.trajectory.duration < other
    assert 1 <= plan.statistics["further_searches"] <= SEARCHES_PER_WAY + 10


def test_the_summary_says_when_more_improvement_would_pay() -> None:
    plan = kinolab.load("rolling_disk_maze", overrides=[STICKY]).solve(seed=1, improve=0.4)
    assert plan.statistics["improvement_unfinished"] == 1.0
    assert re.search(r"(after|than) 0\.4 s.*: --set planner.improve=2", str(plan))


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


def start_of(motion: Trajectory) -> Start:
    """Return a motion of whose way nothing is known."""
    return Start(motion, motion.duration)


@dataclass
class Race:
    """Two motions of which the longer one gets shorter sooner."""

    problem: PlanningTask
    clock: WorkClock
    given: list[Trajectory]
    turns: Counter[int]
    taken: float = 0.0  # [s] of work

    def shortened(self, work: float, asked: Effort | None = None) -> list[RefinedWay]:
        """Shorten them with so many seconds of work; return them, the shortest last."""
        plan = self.problem.solve("rrt_fast", seed=1, optimize=False)
        request = Request(None, time_limit=100.0, improve=asked)
        improver = PlanImprover(self.problem, make_planner(self.problem, None, {}), request, float)
        improver._seconds = work
        improver._incumbent = Incumbent(
            self.problem, replace(plan, trajectory=self.given[0]), Budget(100.0), float
        )
        begun = self.clock.seconds
        ways = improver._halved(
            list(map(start_of, self.given)), Budget(work, clock=lambda: self.clock.seconds)
        )
        self.taken = self.clock.seconds - begun
        return ways


@pytest.fixture
def race(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Race]:
    problem = problem_of(tmp_path, OPEN)
    shorter, longer = standing(problem, 10.0), standing(problem, 11.0)
    turns: Counter[int] = Counter()

    def shortened(
        problem: PlanningTask,
        given: Trajectory,
        spent: Callable[[], float],
        minimised: Callable[[float, float], object],
    ) -> Iterator[Trajectory]:
        factor, duration = QUICK if given is longer else SLOW, given.duration
        while spent() < 1.0:
            charge(TURN)
            turns[id(given)] += 1
            duration *= factor
            minimised(math.inf, 0.0)  # what there is, is known
            yield standing(problem, duration)

    monkeypatch.setattr(forks, "processors", lambda: 1)  # forks count no turns here
    monkeypatch.setattr(trajopt, "shortened", shortened)
    monkeypatch.setattr(trajopt, "make_exact", lambda *_: None)  # they end nowhere
    monkeypatch.setattr(Incumbent, "take", lambda *_: True)
    with counted_work() as clock:
        yield Race(problem, clock, [shorter, longer], turns)


def test_of_two_ways_the_one_goes_on_that_gets_shorter(race: Race) -> None:
    """How long motions are at first does not decide; both are shortened to the end, at once."""
    shorter, longer = race.given
    lost, won = race.shortened(6.0)
    assert (lost.given.motion, won.given.motion) == (shorter, longer)
    assert race.turns[id(shorter)] == pytest.approx(6.0 / TURN, abs=1)
    assert race.turns[id(longer)] == pytest.approx(6.0 / TURN, abs=1)
    assert won.duration == pytest.approx(11.0 * QUICK ** race.turns[id(longer)])
    assert race.taken == pytest.approx(6.0, abs=2 * TURN)  # what two processors need


def test_of_four_ways_the_best_has_most_of_the_work(race: Race) -> None:
    _, longer = race.given
    others = [standing(race.problem, 10.5), standing(race.problem, 10.6)]
    race.given += others
    *_, won = race.shortened(16.0)
    assert won.given.motion is longer
    # two rounds of 8 s, by two processors: 4 s for each of four, 8 s for each of two
    assert race.turns[id(longer)] == pytest.approx((4 + 8) / TURN, abs=3)
    assert 16.0 <= race.taken <= 1.25 * 16.0


# --- when to end ---


@pytest.mark.parametrize(
    ("factor", "work", "asked", "expected"),
    [
        (QUICK, 4.0, "auto", 12.0),  # more than 5 % shorter in the second half of 4 and 8 s
        (0.999, 4.0, "auto", 4.0),
        (QUICK, 4.0, 4.0, 4.0),  # as much as was said, and no more
        (QUICK, 12.0, "auto", 12.0),  # the most
    ],
)
def test_there_is_as_much_work_again_while_a_motion_becomes_shorter(
    factor: float,
    work: float,
    asked: Effort,
    expected: float,
    race: Race,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(globals(), "QUICK", factor)
    monkeypatch.setitem(globals(), "SLOW", max(factor, SLOW))
    monkeypatch.setattr(improve, "MOST_SECONDS", 12.0)
    race.shortened(work, asked)
    assert expected <= race.taken <= 1.25 * expected


@pytest.mark.parametrize(
    ("spent", "others", "expected"),
    [
        (3.0, [11.0, 12.0], 0.05),  # three starts, three more: 1/2 of 10 %
        (1.0, [11.0, 12.0], 0.08125),  # and with work for 13 more, 13/16
        (3.0, [10.0, 12.0], 0.0),
        (3.0, [11.0], math.inf),  # two say nothing of the spread
    ],
)
def test_what_further_starts_may_gain_follows_from_the_spread(
    spent: float, others: list[float], expected: float, race: Race
) -> None:
    """Records of n + m durations drawn alike: one of the last m has probability m / (n + m)."""
    problem = race.problem
    plan = problem.solve("rrt_fast", seed=1, optimize=False)
    incumbent = Incumbent(problem, plan, Budget(100.0), float)
    left = 3.0 if spent == 3.0 else 13.0 / 3.0  # [s]
    remaining = Budget(spent + left, started=0.0, clock=lambda: spent)
    motions = [standing(problem, duration) for duration in (*others, 10.0)]
    ways = [RefinedWay(incumbent, start_of(motion), remaining, alone=True) for motion in motions]
    assert _expected_gain(ways, remaining) == pytest.approx(expected)


def test_a_way_that_there_is_no_time_to_look_at_is_as_long_as_its_motion(race: Race) -> None:
    problem, (shorter, _) = race.problem, race.given
    plan = problem.solve("rrt_fast", seed=1, optimize=False)
    incumbent = Incumbent(problem, plan, Budget(100.0), float)
    over = Budget(1.0, started=0.0, clock=lambda: 2.0)
    starts = Starts(incumbent, make_planner(problem, None, {}), over)
    assert starts.least_duration(shorter) == shorter.duration
