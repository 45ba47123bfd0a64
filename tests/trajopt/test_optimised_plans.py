"""Plans are made exact and shorter after the search, never worse, and never unverified."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab import cli, trajopt
from kinolab.concurrency import forks
from kinolab.problem import PlanningTask
from kinolab.runs import check_run, write_run
from kinolab.search import Budget
from kinolab.solve import PlanResult, improve, make_planner
from kinolab.solve.improve import PATIENCE, PlanImprover
from kinolab.solve.plan import Request
from kinolab.trajectory import Trajectory
from kinolab.trajopt import make_exact as true_repair
from kinolab.trajopt import shortened as true_shortened
from kinolab.trajopt.nlp.decision import resampled
from tests.planners.test_planners import bits
from tests.support import WALL, coin_after, problem_of

EXACT = 1e-6  # [SI units] from the goal's centre
MOST = 50_000  # iterations, far more than the search needs
MORE = 1.0  # [s] of work, which is enough for further searches, too

# Both are improved for 0.5 s of work: enough to end exactly in the goal and to become shorter.
DRIVE = """
schema = 1
title = "A robot with limited acceleration drives to a place where it can rest"
system = { name = "unicycle2_v0" }
world.bounds = { x = [-0.5, 1], y = [-0.5, 0.5] }
[goal]
x = 0.6
y = 0.0
theta = 0.0
v = 0.0
w = 0.0
tolerance = 0.1
[integration]
method = "euler"
step = 0.1
truth = "discrete"
[planner]
improve = 0.5
"""
COIN = """
schema = 1
title = "A coin rolls around a wall"
system = { name = "rolling_disk" }
world.bounds = { x = [-1, 3], y = [-2, 2] }
world.ground = "plane"
goal = { x = 2, y = 0, at_rest = true, tolerance = 0.3 }
planner.improve = 0.5
"""


@dataclass(frozen=True)
class Both:
    """A problem, its plan without optimisation, and with it."""

    problem: PlanningTask
    raw: PlanResult
    found: PlanResult


def both(folder: Path, text: str) -> Both:
    problem = problem_of(folder, text)
    raw = problem.solve(seed=1, max_iterations=MOST, optimize=False)
    with pytest.MonkeyPatch.context() as patch:
        patient(patch)
        return Both(problem, raw, problem.solve(seed=1, max_iterations=MOST))


def patient(patch: pytest.MonkeyPatch) -> None:
    """Let work alone end what is counted as work, however busy the computer is."""
    patch.setattr(improve, "PATIENCE", 1000.0)


@pytest.fixture(scope="module", autouse=True)
def one_processor() -> Iterator[None]:
    """Tests replace functions, and of two lines of work time decides which is the first to tell."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(forks, "processors", lambda: 1)
        yield


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Both:
    """A robot whose steps have a fixed length."""
    return both(tmp_path_factory.mktemp("drive"), DRIVE)


@pytest.fixture(scope="module")
def rolled(tmp_path_factory: pytest.TempPathFactory) -> Both:
    """A coin in continuous time, and a wall in its way."""
    wall = WALL.replace("3.0, 0.0", "1.0, 0.0").replace("4.0, 1.0", "1.0, 1.0")
    return both(tmp_path_factory.mktemp("coin"), COIN + wall)


@pytest.fixture(params=["driven", "rolled"])
def solved(request: pytest.FixtureRequest) -> Both:
    made: Both = request.getfixturevalue(request.param)
    return made


@pytest.fixture
def drive(driven: Both) -> PlanningTask:
    return driven.problem


def trajectory_of(found: PlanResult) -> Trajectory:
    assert found.trajectory is not None, found.message
    return found.trajectory


def made_by(found: PlanResult) -> list[str]:
    return [one.by for one in found.improvements]


def replaced(monkeypatch: pytest.MonkeyPatch, name: str, other: Callable[..., Any]) -> None:
    monkeypatch.setattr(trajopt, name, other)


# --- what comes out ---


def test_a_plan_ends_exactly_in_the_goal_and_is_never_longer_than_the_raw_one(
    solved: Both,
) -> None:
    problem, raw, end = solved.problem, trajectory_of(solved.raw), trajectory_of(solved.found)
    assert solved.found.status == "solved"
    assert kinolab.verify(problem, end).passed
    assert end.duration < raw.duration
    assert problem.goal_distance(end.x[-1]) < EXACT < problem.goal_distance(raw.x[-1])
    assert solved.found.statistics["raw_duration"] == raw.duration
    assert solved.found.statistics["final_duration"] == end.duration


def test_the_improvements_tell_how_it_came_about(solved: Both) -> None:
    first, *later = solved.found.improvements
    assert (first.by, first.duration) == ("search", solved.raw.cost)
    assert {one.by for one in later} <= {"search", "repair", "shorten"}
    ranks = [(one.goal_distance >= EXACT, one.duration) for one in (first, *later)]
    assert ranks == sorted(set(ranks), reverse=True)  # each is exact at last, or shorter
    assert later[-1].goal_distance < EXACT
    times = [one.after for one in (first, *later)]
    assert times == sorted(times)
    assert later[-1].duration == solved.found.cost


def test_whole_steps_stay_whole(driven: Both) -> None:
    steps = np.diff(trajectory_of(driven.found).t)
    assert np.abs(steps - driven.problem.step).max() < 1e-12


def test_the_margin_is_the_least_room_of_the_motion(rolled: Both) -> None:
    """A rim of 0.25 m about the centre, which is 0.25 m above the ground, and half of 5 cm.

    The coin's motion between the knots is known in closed form.
    """
    end = trajectory_of(rolled.found)
    spans = np.diff(end.t)[:, None] * np.linspace(0, 1, 50)
    rows = zip(end.x, end.u, spans, strict=False)
    x, y = np.vstack([coin_after(*row) for row in rows])[:, :2].T
    to_wall = np.hypot(np.maximum(np.abs(x - 1.0) - 0.05, 0), np.maximum(np.abs(y) - 0.5, 0))
    margin = rolled.found.statistics["margin"]
    assert to_wall.min() - np.hypot(0.25, 0.025) - 1e-6 <= margin <= to_wall.min() - 0.025
    assert margin > 0
    assert rolled.found.certificate is not None
    assert rolled.found.certificate.margin is not None
    assert margin == rolled.found.certificate.margin.clearance
    assert "margin" not in rolled.raw.statistics


def test_a_search_that_missed_the_goal_is_led_into_it(driven: Both, tmp_path: Path) -> None:
    strict = problem_of(tmp_path, DRIVE, "goal.tolerance=1e-6")
    missed = replace(driven.raw, status="approximate", certificate=None, message="missed")
    found = improver(strict, 100.0, MOST, 0.0).plan(missed, Budget(10.0))
    assert found.status == "solved"
    assert kinolab.verify(strict, trajectory_of(found)).passed
    assert "the search alone had missed" in found.message


# --- what does not come out ---


def test_without_optimisation_a_plan_is_what_the_search_gave(solved: Both) -> None:
    problem, raw = solved.problem, solved.raw
    alone = make_planner(problem, None, {}).solve(problem, 1, Budget(math.inf, MOST))
    assert trajectory_of(raw).u.tobytes() == alone.u.tobytes()
    assert made_by(raw) == ["search"]
    assert "raw_duration" not in raw.statistics


def test_improving_for_no_time_is_no_optimisation(driven: Both, tmp_path: Path) -> None:
    never = problem_of(tmp_path, DRIVE, "planner.improve=0")
    assert bits(never.solve(seed=1, max_iterations=MOST)) == bits(driven.raw)


def test_a_repair_that_fails_leaves_what_was_searched(
    driven: Both, monkeypatch: pytest.MonkeyPatch
) -> None:
    replaced(monkeypatch, "make_exact", lambda *_: None)
    replaced(monkeypatch, "shortened", lambda *_: iter(()))
    found = driven.problem.solve(seed=1, max_iterations=MOST)
    assert (found.status, set(made_by(found))) == ("solved", {"search"})
    assert found.improvements[0].duration == driven.raw.cost >= trajectory_of(found).duration


def test_where_a_repair_fails_shortening_may_make_the_plan_exact(
    driven: Both, monkeypatch: pytest.MonkeyPatch
) -> None:
    replaced(monkeypatch, "make_exact", lambda *_: None)
    found = driven.problem.solve(seed=1, max_iterations=MOST)
    assert "repair" not in made_by(found)
    assert made_by(found)[-1] == "shorten"
    assert found.goal_distance < 1e-6
    assert kinolab.verify(driven.problem, trajectory_of(found)).passed


def test_a_motion_too_quick_for_the_middle_of_the_goal_gets_more_steps(driven: Both) -> None:
    problem, found = driven.problem, trajectory_of(driven.found)
    fewer = int(0.9 * len(found.u))  # which are nearly the fewest that do
    few = resampled(found.t, found.x, found.u, fewer, problem.space)
    quick = replace(found, t=problem.step * np.arange(fewer + 1), x=few.x, u=few.u)
    exact = trajopt.make_exact(problem, quick)
    assert exact is not None
    assert len(exact.u) > fewer
    assert problem.goal_distance(exact.x[-1]) < EXACT
    assert kinolab.verify(problem, exact).passed


def test_what_the_verifier_refuses_is_discarded(
    driven: Both, monkeypatch: pytest.MonkeyPatch
) -> None:
    def lying(_problem: PlanningTask, given: Trajectory, *_: object) -> Trajectory:
        half = max(len(given.u) // 2, 1)
        return replace(given, t=given.t[: half + 1], x=given.x[-half - 1 :], u=given.u[-half:])

    replaced(monkeypatch, "make_exact", lying)
    replaced(monkeypatch, "shortened", lambda *given: iter([lying(*given)]))
    found = driven.problem.solve(seed=1, max_iterations=MOST)
    assert set(made_by(found)) == {"search"}
    assert kinolab.verify(driven.problem, trajectory_of(found)).passed


def test_a_planner_leaves_the_time_to_the_optimiser(drive: PlanningTask) -> None:
    """Otherwise its own search for shorter motions would use it up."""
    found = drive.solve(planner="ao_rrt", seed=1, max_iterations=MOST)
    assert found.statistics["improvements"] == 0
    assert found.iterations < MOST


# --- how long ---


def test_the_same_iterations_give_the_same_bits_again(
    driven: Both, monkeypatch: pytest.MonkeyPatch
) -> None:
    patient(monkeypatch)
    again = driven.problem.solve(seed=1, max_iterations=MOST)
    assert bits(again) == bits(driven.found)
    assert made_by(again) == made_by(driven.found)


@dataclass
class Asked:
    """A clock that goes on by questions alone."""

    tick: float  # [s]
    now: float = 1.0

    def __call__(self) -> float:
        self.now += self.tick
        return self.now


def improver(problem: PlanningTask, limit: float, most: int | None, tick: float) -> PlanImprover:
    """Return what improves plans as if their search had taken a second."""
    wanted = Request(None, time_limit=limit, max_iterations=most, improve=MORE)
    return PlanImprover(problem, make_planner(problem, None, {}), wanted, Asked(tick))


@pytest.mark.parametrize("most", [MOST, None])
def test_a_plan_that_is_found_late_is_made_exact_and_no_more(
    most: int | None, driven: Both
) -> None:
    late = improver(driven.problem, 1.0, most, 0.01).plan(driven.raw, Budget(1.0))
    assert made_by(late) == ["search", "repair"]
    assert late.cost == driven.raw.cost


def test_work_that_is_left_is_for_further_searches(driven: Both) -> None:
    found = improver(driven.problem, 100.0, None, 0.0).plan(driven.raw, Budget(100.0))
    assert found.statistics["further_searches"] > 0
    assert found.seed == driven.raw.seed
    assert trajectory_of(found).duration < trajectory_of(driven.raw).duration


def test_a_busy_computer_gives_the_same_bits_as_an_idle_one(solved: Both) -> None:
    """The budget is work; all that a slow clock may do is to say that it takes long."""
    idle, busy = (
        improver(solved.problem, 100.0, None, tick).plan(solved.raw, Budget(100.0))
        for tick in (0.0, 0.0005)
    )
    assert idle.timings["improve"] < busy.timings["improve"]
    assert bits(idle) == bits(busy)
    assert made_by(idle) == made_by(busy)


def test_a_computer_that_is_hopelessly_slow_stops_in_time(driven: Both) -> None:
    slow = improver(driven.problem, 100.0, None, 0.1)
    found = slow.plan(driven.raw, Budget(100.0))
    assert found.status == "solved"
    assert found.timings["improve"] <= PATIENCE * MORE + 3.0  # [s] by that clock


def test_ctrl_c_during_optimisation_keeps_the_best_so_far(
    drive: PlanningTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    budgets: list[Budget] = []
    after = 0

    def pressed(
        problem: PlanningTask, given: Trajectory, spent: Callable[[], float], _: object
    ) -> Iterator[Trajectory]:
        def share() -> float:
            nonlocal after
            after += budgets[-1].interrupted
            budgets[-1].end()
            return spent()

        return true_shortened(problem, given, share)

    replaced(monkeypatch, "shortened", pressed)
    found = drive.solve(seed=1, max_iterations=MOST, watch=budgets.append, improve=MORE)
    assert (found.status, found.interrupted, found.exit_code) == ("solved", True, 130)
    assert made_by(found) == ["search", "repair", "repair"]
    assert after <= 1  # the second time it is broken off
    assert kinolab.verify(drive, trajectory_of(found)).passed


def test_ctrl_c_during_a_repair_keeps_what_was_searched(
    driven: Both, monkeypatch: pytest.MonkeyPatch
) -> None:
    budgets: list[Budget] = []

    def pressed(*given: Any) -> Trajectory | None:
        budgets[-1].end()
        return true_repair(*given)

    replaced(monkeypatch, "make_exact", pressed)
    found = driven.problem.solve(seed=1, max_iterations=MOST, watch=budgets.append)
    assert set(made_by(found)) == {"search"}
    assert trajectory_of(found).duration <= trajectory_of(driven.raw).duration
    assert kinolab.verify(driven.problem, trajectory_of(found)).passed
    assert (found.status, found.interrupted) == ("solved", True)


# --- who is told ---


def test_each_improvement_is_written_when_it_is_found(drive: PlanningTask, tmp_path: Path) -> None:
    """Each one is better: it is the first that ends in the goal's centre, or it is shorter."""
    told: list[tuple[bool, float]] = []

    def improved(better: PlanResult) -> None:
        write_run(tmp_path / "run", drive, better)
        assert check_run(tmp_path / "run").passed
        end = trajectory_of(better)
        told.append((drive.goal_distance(end.x[-1]) > EXACT, end.duration))

    found = drive.solve(seed=1, max_iterations=MOST, improved=improved)
    assert len(told) > 1
    assert told == sorted(set(told), reverse=True)
    assert told[-1] == (False, found.cost)


@pytest.mark.parametrize("planner", ["auto", "rrt"])
def test_of_several_searches_the_first_to_find_a_plan_improves_it(
    planner: str, drive: PlanningTask
) -> None:
    """In threads, and in processes, where the motion is told through a pipe."""
    better: list[PlanResult] = []
    found = drive.solve(
        planner, seed=1, jobs=2, max_iterations=MOST, time_limit=100.0, improved=better.append
    )
    assert {"search", "repair"} <= set(made_by(found))
    assert kinolab.verify(drive, trajectory_of(found)).passed
    assert [one.cost for one in better][-1] == found.cost
    assert {a.status for a in found.attempts} == {"solved", "ended"}


def test_the_command_says_what_goes_on_and_writes_the_same_bits(
    driven: Both,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "table.toml").write_text(DRIVE)
    options = ("--max-iterations", str(MOST), "--no-animation")
    patient(monkeypatch)
    monkeypatch.chdir(tmp_path)
    assert cli.run(["table.toml", *options]) == 0
    done = capsys.readouterr()
    with np.load(tmp_path / "runs" / "table" / "trajectory.npz") as written:
        assert written["x"].tobytes() == trajectory_of(driven.found).x.tobytes()
        assert written["u"].tobytes() == trajectory_of(driven.found).u.tobytes()
    raw, final = driven.raw.cost, driven.found.cost
    assert f"optimising a motion of {raw:.2f} s" in done.err
    assert f"optimising: {final:.2f} s (first found: {raw:.2f} s), after " in done.err
    assert f"motion of {final:.2f} s (first found: {raw:.2f} s), ending " in done.out
    assert cli.run(["table.toml", *options, "--no-optimize"]) == 0
    bare = capsys.readouterr()
    assert f"motion of {raw:.2f} s, ending " in bare.out
    assert "optimising" not in bare.err
