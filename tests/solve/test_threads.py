"""Several searches of a compiled planner, in threads of one process: as good as alone."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from kinolab import planners
from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner, Budget
from kinolab.search.tree import AbstractCompiledPlanner, compiled_planner
from kinolab.solve import PlanResult, solve
from kinolab.solve.parallel import JobsError
from tests.support import OPEN, environment, problem_of

HARD = ("goal.x=4", "goal.tolerance=1e-9")  # is not hit by chance
SETTINGS = {"planner": "rrt_fast", "goal_connection_period": 0}


def bits(found: PlanResult) -> bytes:
    assert found.trajectory is not None
    return found.trajectory.to_npz()


@pytest.fixture(scope="module")
def hard(tmp_path_factory: pytest.TempPathFactory) -> PlanningTask:
    return problem_of(tmp_path_factory.mktemp("hard"), OPEN, *HARD)


@pytest.fixture
def no_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no process be started."""

    def refuse() -> Any:
        raise AssertionError("a process was started")

    monkeypatch.setattr("kinolab.solve.jobs.WorkerProcess", refuse)


def test_compiled_planners_search_in_threads_and_no_others() -> None:
    assert not AbstractPlanner.in_threads
    for name in planners.built_in():
        kind = planners.get(name)
        assert kind.in_threads == issubclass(kind, AbstractCompiledPlanner)


@pytest.mark.usefixtures("no_process")
@pytest.mark.parametrize("planner", ["rrt_fast", "kpiece_fast"])
def test_the_winner_is_the_plan_that_its_seed_gives_alone(
    planner: str, table: PlanningTask
) -> None:
    found = table.solve(planner, seed=5, jobs=3, max_iterations=20_000, time_limit=600.0)
    assert found.status == "solved"
    assert found.certificate is not None
    assert found.certificate.passed
    assert [attempt.seed for attempt in found.attempts] == [5, 6, 7]
    alone = table.solve(planner, seed=found.seed, max_iterations=20_000, time_limit=600.0)
    assert bits(found) == bits(alone)
    for attempt in found.attempts:
        if attempt.status == "ended":
            assert attempt.detail == f"seed {found.seed} had won."
        else:
            assert attempt.status == "solved"


@pytest.mark.usefixtures("no_process")
@pytest.mark.parametrize("planner", ["rrt_fast", "kpiece_fast"])
def test_searches_at_once_know_nothing_of_each_other(planner: str, hard: PlanningTask) -> None:
    """Each ends as near to the goal as it does alone, to the last bit."""
    limits: dict[str, Any] = {"max_iterations": 3000, "time_limit": 600.0}
    found = hard.solve(planner, seed=1, jobs=3, **limits)
    alone = [hard.solve(planner, seed=seed, **limits) for seed in (1, 2, 3)]
    told = [attempt.goal_distance for attempt in found.attempts]
    assert told == [plan.goal_distance for plan in alone]
    assert bits(found) == bits(min(alone, key=lambda plan: plan.goal_distance))


@pytest.mark.usefixtures("no_process")
def test_searches_go_on_until_the_time_is_over(table: PlanningTask) -> None:
    found = table.solve("rrt_fast", seed=1, jobs=2, anytime=True, time_limit=0.3)
    seeds = [attempt.seed for attempt in found.attempts]
    assert {seed % 2 for seed in seeds} == {0, 1}
    assert len(set(seeds)) == len(seeds)
    costs = [attempt.cost for attempt in found.attempts if attempt.status == "solved"]
    assert found.cost == min(cost for cost in costs if cost is not None)


@pytest.mark.usefixtures("no_process")
def test_a_search_that_fails_is_told_and_the_others_go_on(
    hard: PlanningTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = compiled_planner.search_state

    def broken(problem: PlanningTask, zoom: float, seed: int) -> Any:
        if seed > 1:
            raise MemoryError
        return made(problem, zoom, seed)

    monkeypatch.setattr(compiled_planner, "search_state", broken)
    found = hard.solve(seed=1, jobs=2, max_iterations=100, **SETTINGS)
    assert [attempt.status for attempt in found.attempts] == ["approximate", "failed"]
    assert found.attempts[1].detail == "it ran out of memory."
    with pytest.raises(JobsError) as caught:
        hard.solve(seed=2, jobs=2, max_iterations=100, **SETTINGS)
    assert caught.value.exit_code == 6


@pytest.mark.usefixtures("no_process")
def test_a_user_who_ends_the_search_gets_what_it_has(hard: PlanningTask) -> None:
    budgets: list[Budget] = []

    def end(iterations: int, _seconds: float) -> None:
        if iterations:
            budgets[0].end()

    found = solve(hard, seed=1, jobs=2, progress=end, watch=budgets.append, **SETTINGS)
    assert found.interrupted
    assert [attempt.seed for attempt in found.attempts] == [1, 2]


PROGRAM = """
import sys, threading, time
import kinolab
problem = kinolab.load(sys.argv[1], overrides=["goal.x=4", "goal.tolerance=1e-9"])
problem.solve("rrt_fast", max_iterations=10)
said = []
def say(iterations, _):
    if iterations and not said:
        said.append(print("searching", flush=True))
from kinolab.solve import solve
try:
    solve(problem, "rrt_fast", jobs=2, time_limit=600.0, goal_connection_period=0, progress=say)
except KeyboardInterrupt:
    late = time.monotonic() + 60.0
    while threading.active_count() > 1 and time.monotonic() < late:
        time.sleep(0.01)
    print("interrupted", threading.active_count(), flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent as on POSIX")
def test_ctrl_c_in_a_program_raises_and_ends_the_threads(tmp_path: Path) -> None:
    (tmp_path / "table.toml").write_text(OPEN)
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, "table.toml"],
        cwd=tmp_path,
        env=environment(),
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "searching\n"
    os.kill(process.pid, signal.SIGINT)
    out, _ = process.communicate(timeout=120)
    assert out == "interrupted 1\n"


@pytest.mark.usefixtures("no_process")
def test_threads_that_lost_end(table: PlanningTask) -> None:
    before = threading.active_count()
    table.solve("rrt_fast", seed=1, jobs=4, max_iterations=20_000, time_limit=600.0)
    late = time.monotonic() + 60.0
    while threading.active_count() > before and time.monotonic() < late:
        time.sleep(0.01)
    assert threading.active_count() == before
