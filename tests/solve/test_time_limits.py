"""What a search does after its time is over, counted: these tests do not depend on how fast it is.

Their clock goes on by looks at it alone. What is counted is work: steps of the machine, questions
to its model, questions about collision, iterations of compiled loops. A search keeps its limit if
little is done between two looks, and little after the look that says that the time is over.
"""

from __future__ import annotations

import gc
import math
import sys
import weakref
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinolab import planners
from kinolab.concurrency.cancel import raise_if_cancelled
from kinolab.dynamics import Model
from kinolab.problem import PlanningTask
from kinolab.search import Budget, Outcome, SearchResult
from kinolab.simulation import CandidateRollouts, CompiledStep
from kinolab.simulation.dop853 import follow
from kinolab.solve.attempt import old_objects_left_alone
from kinolab.world import CollisionChecker
from tests.planners.test_planners import hard
from tests.scenes import ROOM, scene
from tests.support import OPEN, problem_of, within

__all__ = ["hard"]  # a fixture

every_planner = pytest.mark.parametrize("name", planners.names())

COUNTED = (
    (CompiledStep, "step"),
    (CandidateRollouts, "follow"),
    (Model, "_call"),
    (CollisionChecker, "collides"),
)
LIMITS = (40, 400)  # looks: while it begins, at its first long piece
WELL_AFTER = 1000  # looks
LATE_LOOKS = 8  # on the way out of what is nested
PIECE_OF_WORK = (
    600  # of what is counted, some 0.1 ms each; a motion that is steered takes thousands
)
TICK = 0.005  # [s] from look to look, as long as a piece of a compiled loop may take


@dataclass
class Clock:
    """Counts what is done between two looks, while a search is on.

    Attributes:
        pieces: Work from look to look, as of the beginning of the search.
        work: Done so far.
        now: In [s].
    """

    pieces: list[int] = field(default_factory=list)
    work: int = 0
    now: float = 0.0
    _seen: int = 0

    def __call__(self) -> float:
        self.note()
        self.now += TICK
        return self.now

    def note(self) -> None:
        """End a piece."""
        self.pieces.append(self.work - self._seen)
        self._seen = self.work


@dataclass
class Watched(Budget):
    """Begins to count where a planner has prepared everything, and knows when it was late."""

    ends_at: float = math.inf  # looks, when it is interrupted
    late_looks: int = 0
    late_work: int = -1  # done when the time was over

    def restart(self) -> None:
        super().restart()
        self.counter.pieces.clear()

    @property
    def counter(self) -> Clock:
        assert isinstance(self.clock, Clock)
        return self.clock

    def expired(self) -> bool:
        self.interrupted |= len(self.counter.pieces) >= self.ends_at
        late = super().expired()
        if late:
            self.late_looks += 1
            if self.late_work < 0:
                self.late_work = self.counter.work
        return late

    def spend(self, iterations: int) -> None:
        self.counter.work += iterations
        super().spend(iterations)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    for owner, name in COUNTED:
        monkeypatch.setattr(owner, name, counted(clock, getattr(owner, name)))
    return clock


def counted(clock: Clock, function: Callable[..., Any]) -> Callable[..., Any]:
    def counting(*arguments: Any, **options: Any) -> Any:
        clock.work += 1
        return function(*arguments, **options)

    return counting


def searched(name: str, problem: PlanningTask, budget: Budget) -> SearchResult:
    with within(300):
        found = planners.make(name, {}).solve(problem, 1, budget)
    if isinstance(budget, Watched):
        budget.counter.note()
    return found


@pytest.fixture(params=["pen", "room"])
def endless(request: pytest.FixtureRequest, hard: PlanningTask, tmp_path: Path) -> PlanningTask:
    """A goal that nobody reaches: a coin's, in a pen without a gate; a robot's, without a door."""
    return hard if request.param == "pen" else scene(tmp_path, "drive", text=ROOM)


def without_looks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take the looks out of all that is long: of steering, of drawing states, of following."""
    for name, module in list(sys.modules.items()):
        if (
            name.startswith("kinolab.")
            and vars(module).get("raise_if_cancelled") is raise_if_cancelled
        ):
            monkeypatch.setattr(module, "raise_if_cancelled", lambda _: None)


# --- the time limit ---


def assert_little_is_done(clock: Clock, budget: Watched, looks: int) -> None:
    """Between any two looks of a search with so many until its limit, and after the limit."""
    assert max(clock.pieces) <= PIECE_OF_WORK
    assert 1 <= budget.late_looks <= LATE_LOOKS
    assert clock.work - budget.late_work <= PIECE_OF_WORK
    assert len(clock.pieces) <= looks + LATE_LOOKS + 4  # others ask what time it is, too


@every_planner
def test_a_search_does_little_between_two_looks_and_next_to_nothing_when_it_is_late(
    name: str, endless: PlanningTask, clock: Clock
) -> None:
    budget = Watched(WELL_AFTER * TICK, clock=clock)
    found = searched(name, endless, budget)
    assert found.outcome in {Outcome.APPROXIMATE, Outcome.NOT_FOUND}
    assert_little_is_done(clock, budget, WELL_AFTER)


def test_a_search_that_does_not_look_is_caught(
    hard: PlanningTask, clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So that the test above can fail."""
    without_looks(monkeypatch)
    searched("kinematic_first", hard, Watched(LIMITS[-1] * TICK, clock=clock))
    assert max(clock.pieces) > PIECE_OF_WORK


@every_planner
@pytest.mark.parametrize("looks", LIMITS)  # well after is dear here: it is searched twice
def test_the_iterations_of_a_search_that_was_cut_short_repeat_it(
    name: str, looks: int, endless: PlanningTask, clock: Clock
) -> None:
    """What was being done when the time was over is little, and counts for nothing."""
    budget = Watched(looks * TICK, clock=clock)
    timed = searched(name, endless, budget)
    assert timed.outcome in {Outcome.APPROXIMATE, Outcome.NOT_FOUND}
    assert_little_is_done(clock, budget, looks)
    again = searched(name, endless, Budget(math.inf, timed.iterations))
    assert again.iterations == timed.iterations
    assert again.u.tobytes() == timed.u.tobytes()
    assert again.statistics.get("motions") == timed.statistics.get("motions")  # of a roadmap


@pytest.mark.parametrize("step", ["1e-6", "1000.0", "1e300"])
def test_a_step_of_any_length_is_a_piece_of_work(step: str, tmp_path: Path, clock: Clock) -> None:
    problem = problem_of(tmp_path, OPEN, f"integration.step={step}")
    budget = Watched(100 * TICK, clock=clock)
    searched("rrt", problem, budget)
    assert max(clock.pieces) <= PIECE_OF_WORK


@pytest.mark.parametrize("name", ["sst", "ao_rrt"])
def test_improving_ends_when_it_should(name: str, tmp_path: Path) -> None:
    """By a clock that only looks drive, the first motion is found at the same time in each run."""
    ends = {}
    for improve, limit in ((0.0, 20.0), (0.4, 20.0), (1e6, 3.0)):
        behind = problem_of(tmp_path, OPEN, "goal.x=2", f"planner.improve={improve}")
        budget = Budget(limit, clock=Clock())
        assert searched(name, behind, budget).outcome is Outcome.SOLVED
        ends[improve] = budget.elapsed
    assert ends[0.0] < 2.0
    # Either looks a few times more at the clock once it is over.
    assert abs(ends[0.4] - (ends[0.0] + 0.4)) <= 6 * TICK
    assert 3.0 <= ends[1e6] <= 3.0 + 6 * TICK


# --- interruption ---


@every_planner
@pytest.mark.parametrize("looks", LIMITS)  # what is late is as late after a time limit
def test_an_interrupted_search_does_next_to_nothing_more(
    name: str, looks: int, endless: PlanningTask, clock: Clock
) -> None:
    budget = Watched(math.inf, clock=clock, ends_at=looks)
    found = searched(name, endless, budget)
    assert found.outcome is Outcome.INTERRUPTED
    assert 1 <= budget.late_looks <= LATE_LOOKS
    assert clock.work - budget.late_work <= PIECE_OF_WORK


@pytest.mark.parametrize("share", [0.0, 0.2, 0.4, 0.6, 0.8, 1.0])
def test_re_simulation_and_verification_end_at_once(
    share: float, table: PlanningTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C comes while intervals are integrated; no further ones are."""
    budgets, calls, last = list[Budget](), 0, math.inf

    def integrated(*arguments: Any) -> Any:
        nonlocal calls
        calls += 1
        if calls == last:
            budgets[0].end()
        return follow(*arguments)

    monkeypatch.setattr("kinolab.simulation.dop853.follow", integrated)
    monkeypatch.setattr("kinolab.simulation.reference.INTERVALS_PER_CALL", 1)
    whole = table.solve(planner="rrt", seed=1, max_iterations=20_000)
    assert whole.status == "solved"
    last, calls = 1 + round(share * (calls - 1)), 0
    cut = table.solve(planner="rrt", seed=1, max_iterations=20_000, watch=budgets.append)
    assert calls == last
    assert (cut.status, cut.interrupted) == ("interrupted", True)
    assert cut.trajectory is not None


# --- the garbage collector ---


def test_a_search_is_not_held_up_by_objects_that_were_there_before(
    table: PlanningTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    frozen: list[int] = []

    def noted(*_: Any) -> SearchResult:
        frozen.append(gc.get_freeze_count())
        return SearchResult(Outcome.NOT_FOUND, np.zeros(1), np.zeros((0, 2)), 0)

    monkeypatch.setattr("kinolab.solve.attempt.search", noted)
    table.solve(seed=1)
    assert frozen[0] > 10_000
    assert gc.get_freeze_count() == 0


def test_what_is_made_while_old_objects_are_left_alone_is_collected() -> None:
    with old_objects_left_alone():
        circle: list[Any] = [Clock()]
        circle.append(circle)
        held = weakref.ref(circle[0])
        del circle
        gc.collect()
        assert held() is None


def test_who_leaves_old_objects_alone_first_ends_it() -> None:
    with old_objects_left_alone():
        with old_objects_left_alone():
            pass
        assert gc.get_freeze_count() > 10_000
    assert gc.get_freeze_count() == 0
