"""Several processes, and planning on: the right plan is kept, every seed is accounted for."""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from multiprocessing import Pipe
from pathlib import Path
from typing import Any

import pytest

import kinolab
from kinolab import cli
from kinolab.concurrency import process_worker
from kinolab.errors import EndpointError, InputError
from kinolab.problem import PlanningTask
from kinolab.runs import check_run, write_run
from kinolab.scenario import builtin_scenarios
from kinolab.solve import PlanResult, worker
from kinolab.solve.parallel import JobsError
from kinolab.solve.plan import Request
from kinolab.solve.solution_pool import SolutionPool
from tests.support import ENTER, OPEN, environment, problem_of

Capture = pytest.CaptureFixture[str]

HARD = ("goal.x=4", "goal.tolerance=1e-9")  # is not hit by chance
HARDLY = tuple(word for setting in HARD for word in ("--set", setting))


def bits(found: PlanResult) -> bytes:
    assert found.trajectory is not None
    return found.trajectory.to_npz()


@pytest.fixture(scope="module")
def hard(tmp_path_factory: pytest.TempPathFactory) -> PlanningTask:
    return problem_of(tmp_path_factory.mktemp("hard"), OPEN, *HARD)


@pytest.fixture(scope="module")
def race(table: PlanningTask) -> PlanResult:
    """The table, by two processes."""
    return table.solve(seed=5, jobs=2, max_iterations=5000)


# --- the first plan wins ---


def test_the_winner_is_the_plan_that_its_seed_gives_alone(
    table: PlanningTask, race: PlanResult
) -> None:
    assert race.status == "solved"
    assert race.seed in (5, 6)
    assert bits(race) == bits(table.solve(seed=race.seed, max_iterations=5000))
    assert race.certificate is not None
    assert race.certificate.passed


def test_every_seed_is_accounted_for(race: PlanResult) -> None:
    assert race.jobs == 2
    assert [attempt.seed for attempt in race.attempts] == [5, 6]
    (winner,) = (attempt for attempt in race.attempts if attempt.seed == race.seed)
    (other,) = (attempt for attempt in race.attempts if attempt.seed != race.seed)
    assert (winner.status, winner.iterations, winner.cost) == ("solved", race.iterations, race.cost)
    assert other.status in {"ended", "solved"}
    if other.status == "ended":
        assert other.detail == f"seed {race.seed} had won."


def test_the_report_tells_of_all_seeds(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "table.toml").write_text(OPEN)
    options = ["--jobs", "2", "--json", "--quiet", "--no-animation"]
    options += ["--out", str(tmp_path / "run")]
    assert cli.run([str(tmp_path / "table.toml"), *options]) == 0
    printed = json.loads(capsys.readouterr().out)
    report = json.loads((tmp_path / "run" / "report.json").read_text())
    assert (printed["jobs"], report["jobs"]) == (2, 2)
    assert [attempt["seed"] for attempt in report["attempts"]] == [1, 2]
    assert report["seed"] in (1, 2)
    assert check_run(tmp_path / "run").passed


def test_one_job_has_one_attempt(table: PlanningTask) -> None:
    found = table.solve(seed=3, max_iterations=5000)
    (attempt,) = found.attempts
    assert (attempt.seed, attempt.status, attempt.cost) == (3, "solved", found.cost)
    assert (found.jobs, found.interrupted) == (1, False)


# --- nobody wins ---


def test_the_nearest_approach_of_all_seeds_is_kept(hard: PlanningTask) -> None:
    found = hard.solve(seed=1, jobs=2, max_iterations=100)
    alone = [hard.solve(seed=seed, max_iterations=100) for seed in (1, 2)]
    nearest = min(alone, key=lambda plan: plan.goal_distance)
    assert (found.status, found.exit_code) == ("approximate", 4)
    assert found.seed == nearest.seed
    assert found.goal_distance == nearest.goal_distance
    assert bits(found) == bits(nearest)
    for attempt, single in zip(found.attempts, alone, strict=True):
        assert (attempt.status, attempt.goal_distance) == ("approximate", single.goal_distance)


def test_nothing_found_by_anyone_is_a_result(tmp_path: Path) -> None:
    """Rates may hardly differ from 0: every motion breaks a limit."""
    still = ("bounds.psi_dot=[-1e-9, 1e-9]", "bounds.phi_dot=[-1e-9, 1e-9]")
    found = problem_of(tmp_path, OPEN, *still).solve(jobs=2, max_iterations=50)
    assert (found.status, found.exit_code) == ("not_found", 3)
    assert [attempt.status for attempt in found.attempts] == ["not_found", "not_found"]


def test_better_is_verified_then_nearer_then_claimed_then_nothing(short_plan: PlanResult) -> None:
    approach = replace(short_plan, status="approximate", goal_distance=3.0)
    ranked = [
        replace(short_plan, goal_distance=9.0),
        replace(approach, status="interrupted", goal_distance=1.0),
        approach,
        replace(short_plan, status="verification_failed", goal_distance=0.0),
        replace(short_plan, status="verification_failed", goal_distance=float("nan")),
        replace(short_plan, status="not_found", trajectory=None, goal_distance=0.0),
    ]
    shuffled = [ranked[k] for k in (3, 0, 5, 2, 4, 1)]
    assert sorted(shuffled, key=lambda plan: plan.rank) == ranked


@pytest.fixture
def short_plan(table: PlanningTask) -> PlanResult:
    return table.solve(seed=1, max_iterations=5000)


# --- anytime ---


@dataclass(frozen=True)
class Anytime:
    """What so many jobs found in a while, and each improvement when it was found."""

    jobs: int
    found: PlanResult
    better: list[PlanResult]


@pytest.fixture(scope="module", params=[1, 2])
def anytime(request: pytest.FixtureRequest, table: PlanningTask) -> Anytime:
    """Tens of searches at least, beginning with seed 4; a process needs a second to begin."""
    better: list[PlanResult] = []
    limits = {"anytime": True, "time_limit": float(request.param)}
    found = table.solve(seed=4, jobs=request.param, improved=better.append, **limits)
    return Anytime(request.param, found, better)


def test_anytime_keeps_the_shortest_plan(anytime: Anytime, table: PlanningTask) -> None:
    found, better = anytime.found, anytime.better
    costs = [plan.cost for plan in better if plan.cost is not None]
    assert costs == sorted(costs, reverse=True)
    assert len(set(costs)) == len(costs)
    assert found.cost == costs[-1]
    solved = [attempt.cost for attempt in found.attempts if attempt.status == "solved"]
    assert found.cost == min(cost for cost in solved if cost is not None)
    assert bits(found) == bits(table.solve(seed=found.seed, max_iterations=5000))


def test_no_seed_is_tried_twice_and_none_is_left_out_by_its_process(anytime: Anytime) -> None:
    jobs = anytime.jobs
    seeds = [attempt.seed for attempt in anytime.found.attempts]
    assert len(set(seeds)) == len(seeds) >= jobs
    for k in range(jobs):
        own = sorted(seed for seed in seeds if seed % jobs == (4 + k) % jobs)
        assert own == list(range(4 + k, 4 + k + jobs * len(own), jobs))


def test_anytime_searches_until_the_time_is_over(hard: PlanningTask) -> None:
    found = hard.solve(seed=1, anytime=True, time_limit=0.5, max_iterations=50)
    assert found.status == "approximate"
    assert len(found.attempts) > 1
    assert found.attempts[-1].after >= 0.5  # [s]
    assert found.goal_distance == min(a.goal_distance for a in found.attempts if a.goal_distance)


def test_every_improvement_is_a_whole_run_on_disk(table: PlanningTask, tmp_path: Path) -> None:
    seen: list[bool] = []

    def improved(found: PlanResult) -> None:
        write_run(tmp_path / "run", table, found)
        seen.append(check_run(tmp_path / "run").passed)

    table.solve(seed=1, anytime=True, time_limit=0.5, improved=improved)
    assert seen
    assert all(seen)


def test_improvements_are_told_on_stderr(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    (tmp_path / "table.toml").write_text(OPEN)
    monkeypatch.chdir(tmp_path)
    assert cli.run(["table.toml", "--anytime", "--time-limit", "0.5", "--no-animation"]) == 0
    done = capsys.readouterr()
    report = json.loads((tmp_path / "runs" / "table" / "report.json").read_text())
    told = [line for line in done.err.splitlines() if " s of motion, after " in line]
    assert told[-1].startswith(f"seed {report['seed']}: {report['cost']:.2f} s of motion")
    assert f"seed {report['seed']} of {len(report['attempts'])} (" in done.out


# --- what goes wrong ---


def children(parent: int) -> list[int]:
    """The processes that a process has started."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[1]) == parent and fields[0] != "Z":
            found.append(int(entry.name))
    return sorted(found)


def searching(command: int) -> list[int]:
    """The processes in which a command searches: its one child, which ends with it, starts them."""
    return [process for child in children(command) for process in children(child)]


def kill_some(home: Path, count: int, number: int, *options: str) -> tuple[int, str, Path]:
    """Start two jobs and kill some; return the exit code, stderr and the run's folder."""
    (home / "table.toml").write_text(OPEN)
    process = subprocess.Popen(
        [sys.executable, "-c", ENTER, "table.toml", *options, "--jobs", "2", "--no-animation"],
        cwd=home,
        env=environment(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    deadline = time.monotonic() + 60
    while len(searching(process.pid)) < 2 and time.monotonic() < deadline:
        time.sleep(0.02)
    for search in searching(process.pid)[:count]:
        os.kill(search, number)
    _, err = process.communicate(timeout=60)
    return process.returncode, err, home / "runs" / "table"


needs_proc = pytest.mark.skipif(not Path("/proc").is_dir(), reason="processes are read in /proc")


@needs_proc
def test_the_others_go_on_where_one_process_is_killed(tmp_path: Path) -> None:
    code, err, folder = kill_some(tmp_path, 1, signal.SIGKILL)
    report = json.loads((folder / "report.json").read_text())
    assert (code, report["status"]) == (0, "solved")
    (failed,) = (entry for entry in report["attempts"] if entry["status"] == "failed")
    assert failed["detail"] == "its process was killed, as happens where memory runs out."
    assert f"warning: seed {failed['seed']}: its process was killed" in err


@needs_proc
@pytest.mark.parametrize(
    ("number", "code", "told"),
    [
        (signal.SIGKILL, 6, "its process was killed, as happens where memory runs out."),
        (signal.SIGSEGV, 70, "its process was ended by SIGSEGV."),
    ],
)
def test_where_all_processes_are_killed_each_is_told(
    number: int, code: int, told: str, tmp_path: Path
) -> None:
    found, err, folder = kill_some(tmp_path, 2, number, *HARDLY)
    assert found == code
    assert [line for line in err.splitlines() if line.startswith("error: ")] == [
        f"error: seed 1: {told}",
        f"error: seed 2: {told}",
    ]
    assert not folder.exists()


def raising(error: BaseException) -> Callable[..., Any]:
    def search(*_: Any, **__: Any) -> Any:
        raise error

    return search


@pytest.mark.parametrize(
    ("error", "code", "told"),
    [
        (MemoryError(), 6, "it ran out of memory."),
        (EndpointError([]), 5, ""),
        (JobsError([], 9), 9, ""),
        (ZeroDivisionError("a mistake"), 70, "ZeroDivisionError: a mistake"),
    ],
)
def test_a_process_tells_what_went_wrong(
    error: Exception, code: int, told: str, table: PlanningTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(worker, "sequential_runs", raising(error))
    ours, theirs = Pipe()
    with ours, theirs:
        worker.search_and_tell(theirs, lambda: table, Request(None), lambda _: None)
        message = ours.recv()
    assert message.exit_code == code
    assert told in message.reason


def test_a_wrong_question_raises_before_any_process_is_started(table: PlanningTask) -> None:
    with pytest.raises(InputError) as caught:
        table.solve(jobs=0)
    assert str(caught.value) == "solve jobs: 0 processes cannot search. Give 1 or more."
    with pytest.raises(InputError, match="Did you mean 'rrt'"):
        table.solve(planner="rtt", jobs=2)
    with pytest.raises(InputError, match="Did you mean 'goal_bias'"):
        table.solve(jobs=2, goal_bia=0.1)


def test_a_system_without_room_for_so_many_processes_is_told(
    table: PlanningTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second process is refused; the first one is ended."""
    start, started = process_worker.WorkerProcess, []

    def refuse(module: str) -> Any:
        if started:
            raise BlockingIOError(11, "Resource temporarily unavailable")
        started.append(start(module))
        return started[0]

    monkeypatch.setattr("kinolab.solve.jobs.WorkerProcess", refuse)
    with pytest.raises(JobsError) as caught:
        table.solve(seed=1, jobs=2)
    told = "seed 2: its process cannot be started ([Errno 11] Resource temporarily unavailable)."
    assert str(caught.value) == f"{told} Ask for fewer."
    assert caught.value.exit_code == 6
    assert started[0].process.poll() is not None


@pytest.mark.parametrize("jobs", ["0", "-1", "two", "257"])
def test_a_number_of_jobs_that_cannot_be_is_refused(
    jobs: str, tmp_path: Path, capsys: Capture
) -> None:
    (tmp_path / "table.toml").write_text(OPEN)
    assert cli.run([str(tmp_path / "table.toml"), "--jobs", jobs]) == 2
    assert "--jobs" in capsys.readouterr().err


# --- from any program ---

SCRIPT = """
import kinolab
problem = kinolab.load("table.toml")
print(problem.solve(seed=1, jobs=2, max_iterations=5000).status)
"""


@pytest.mark.parametrize("way", ["file", "stdin"])
def test_a_script_needs_no_guard(way: str, tmp_path: Path) -> None:
    """The processes do not read it again, so that it may plan on its first level."""
    (tmp_path / "table.toml").write_text(OPEN)
    (tmp_path / "script.py").write_text(SCRIPT)
    done = subprocess.run(
        [sys.executable, "-W", "error", "script.py" if way == "file" else "-"],
        cwd=tmp_path,
        env=environment(),
        input=SCRIPT if way == "stdin" else None,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert (done.stdout, done.stderr, done.returncode) == ("solved\n", "", 0)


def test_ctrl_c_in_a_program_raises_and_ends_the_processes(hard: PlanningTask) -> None:
    def pressed(*_: Any) -> None:
        raise KeyboardInterrupt

    before = children(os.getpid()) if Path("/proc").is_dir() else []
    with pytest.raises(KeyboardInterrupt):
        hard.solve(jobs=2, time_limit=60.0, progress=pressed)
    if Path("/proc").is_dir():
        assert children(os.getpid()) == before


# --- a problem in another process ---


@pytest.mark.parametrize("name", builtin_scenarios())
def test_a_problem_that_was_sent_is_the_same(name: str) -> None:
    kinolab.load(name)  # its machine is in the cache from now on
    problem = kinolab.load(name)
    arrived = pickle.loads(pickle.dumps(problem))
    assert arrived.scenario == problem.scenario
    assert arrived.scenario.origin.file == problem.scenario.origin.file
    x, u = problem.start, problem.model.control_bounds.mean(axis=1)
    assert (arrived.model.f(x, u) == problem.model.f(x, u)).all()
    assert arrived.goal_distance(x) == problem.goal_distance(x)
    clearances = [p.checker().clearance(*p.placement(x)) for p in (problem, arrived)]
    assert clearances[0] == clearances[1]


def test_a_problem_that_was_sent_has_the_same_plans(table: PlanningTask) -> None:
    arrived = pickle.loads(pickle.dumps(table))
    assert bits(arrived.solve(seed=2, max_iterations=5000)) == bits(
        table.solve(seed=2, max_iterations=5000)
    )


def test_findings_without_an_attempt_have_no_plan() -> None:
    assert SolutionPool(2).plan(interrupted=True) is None
