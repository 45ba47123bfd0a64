"""The benchmarks count right, say what they could not count, and compare what is alike."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import threading
import time
from argparse import Namespace
from functools import cache
from runpy import run_path
from typing import Any

import numpy as np
import pytest

import kinolab
from benchmarks.versus import cpp, ours, tables
from benchmarks.versus.ratios import ratio
from benchmarks.versus.runs import (
    AS_IN_OMPL,
    KINOLAB,
    OMPL,
    OMPL_PLANNERS,
    PROBLEMS,
    Entrant,
    Run,
    entrants,
)
from benchmarks.versus.verdict import Judge
from kinolab.problem import PlanningTask
from kinolab.runs import write_run
from kinolab.simulation.machine import states_under
from tests.support import ROOT, environment

SCRIPT = ROOT / "benchmarks" / "gallery.py"
GALLERY = run_path(str(SCRIPT))
CASE = GALLERY["Case"]("maze", "rolling_disk", "rrt")
LIMIT = 100.0  # [s] of the search
DRIVE = """
schema = 1
title = "A robot with limited acceleration drives straight ahead"
system = { name = "unicycle2_v0" }
world.bounds = { x = [-1, 2], y = [-1, 1] }
[goal]
x = 0.4
y = 0.0
theta = 0.0
at_rest = true
tolerance = 0.1
[integration]
method = "euler"
step = 0.05
truth = "discrete"
"""
SLEEP = [sys.executable, "-c", "import time; time.sleep(60)"]


def run(exit_code: int | None = 0, search: float | None = 1.0, **facts: Any) -> Any:
    given = {"check_code": 0, "wall": 2.0, "iterations": 10, "duration": 20.0, "complaint": ""}
    return GALLERY["Run"]("maze", 1, exit_code=exit_code, search=search, **given | facts)


def row(*runs: Any) -> list[str]:
    """Return the cells of the table's only row, without the names."""
    *_, last = GALLERY["table"]([CASE], runs, LIMIT).splitlines()
    names, cells = last.strip("| ").split(" | ")[:3], last.strip("| ").split(" | ")[3:]
    assert names == ["maze", "rolling_disk", "rrt"]
    return cells


def test_the_benchmark_explains_itself() -> None:
    done = subprocess.run(
        [sys.executable, str(SCRIPT), "--help"],
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0
    for option in ("--seeds", "--planner", "--time-limit", "--jobs", "--json", "--keep"):
        assert option in done.stdout


def test_where_all_is_solved_the_figures_are_plain() -> None:
    runs = [run(search=search, duration=10 * search) for search in (4.0, 1.0, 2.0)]
    assert row(*runs) == ["3/3", "3/3", "2.0", "4.0", "20.0", "–"]


def test_a_search_without_a_plan_counts_as_the_limit_and_is_marked() -> None:
    """The worst one always; the median once it is, or leans on, such a search."""
    solved, nothing = run(search=2.0), run(3, search=99.0, duration=None, check_code=None)
    assert row(solved, solved, nothing) == ["2/3", "2/2", "2.0", "≥ 100.0", "20.0", "3 (1)"]
    assert row(solved, nothing)[2:4] == ["≥ 51.0", "≥ 100.0"]
    assert row(solved, nothing, nothing)[2:4] == ["≥ 100.0", "≥ 100.0"]


def test_an_approximation_is_no_plan() -> None:
    """It has a motion, whose duration does not count."""
    assert row(run(), run(4, duration=500.0)) == [
        "1/2",
        "1/1",
        "≥ 50.5",
        "≥ 100.0",
        "20.0",
        "4 (1)",
    ]


def test_a_plan_that_the_check_refuses_shows() -> None:
    assert row(run(), run(check_code=7), run(check_code=None))[:2] == ["3/3", "1/3"]


def test_a_crash_leaves_a_row_without_figures() -> None:
    """No report, whatever else there is on stdout; a signal gives a negative exit code."""
    crashed = GALLERY["Ended"](70, "", "Traceback\n  a line\nerror: a mistake in kinolab\n")
    shot = GALLERY["Ended"](-11, '{"timings": ', "")
    runs = [GALLERY["result"](CASE, 1, ended, None, 1.0) for ended in (crashed, shot)]
    assert row(*runs) == ["0/2", "–", "≥ 100.0", "≥ 100.0", "–", "-11 (1), 70 (1)"]
    assert str(runs[0]) == "maze, seed 1: exit 70: error: a mistake in kinolab"


def test_killed_and_interrupted_runs_are_said() -> None:
    options = Namespace(time_limit=LIMIT, seeds=3, jobs=2)
    runs = [run(), run(None, search=None, duration=None, check_code=None)]
    text = " ".join(GALLERY["circumstances"](options, runs, 3))
    assert "2 runs side by side" in text
    assert "1 of the runs took longer than 220 s and were killed" in text
    assert "Interrupted after 2 of 3 runs" in text
    assert row(*runs)[-1] == "killed (1)"


def test_what_was_optimised_is_compared_with_the_plan_it_began_with() -> None:
    """Medians are of those that are left, and what is not optimised is counted."""
    short = {"duration": 20.0, "goal_distance": 1e-9}
    runs = [run(optimised=8.0, **short), run(optimised=12.0, **{**short, "goal_distance": 2e-8})]
    assert row(*runs, run())[6:] == ["10.0", "50%", "2.0e-08", "1"]
    options = Namespace(time_limit=LIMIT, seeds=3, jobs=1, optimise=5.0)
    text = " ".join(GALLERY["circumstances"](options, runs, 2))
    assert "5 s of optimisation each leave 50% of the duration, in the median of 2 plans." in text
    assert len(row(run(), run())) == 6


def test_a_plan_is_optimised_from_the_files_of_its_run(tmp_path: Any) -> None:
    """A double integrator's shortest time is that of full thrust and full brake, 2 sqrt(d / a)."""
    problem = kinolab.load(write_drive(tmp_path))
    found = problem.solve(seed=1, time_limit=20.0, improve=0)
    write_run(tmp_path / "run", problem, found)
    given = run(duration=found.cost)
    options = Namespace(optimise=5.0)
    made = GALLERY["optimised"](GALLERY["Processes"](), given, tmp_path / "run", options)
    shortest = 2 * np.sqrt(0.4 / 0.25)
    assert shortest - problem.step <= made.optimised <= 1.01 * shortest + problem.step
    assert made.goal_distance < 1e-6
    absent = GALLERY["optimised"](GALLERY["Processes"](), given, tmp_path / "no", options)
    assert "not optimised: " in str(absent)
    assert row(absent)[6:] == ["–", "–", "–", "1"]


def write_drive(folder: Any) -> Any:
    file = folder / "drive.toml"
    file.write_text(DRIVE, encoding="utf-8")
    return file


def test_a_scenario_that_was_not_reached_has_no_row() -> None:
    assert len(GALLERY["table"]([CASE], [], LIMIT).splitlines()) == 2


def test_a_process_that_takes_too_long_is_killed() -> None:
    begun = time.monotonic()
    ended = GALLERY["Processes"]().run(SLEEP, 0.3)
    assert ended.code is None
    assert time.monotonic() - begun < 30  # [s]; it would sleep for 60


def test_an_interrupt_ends_what_runs_and_starts_nothing_more() -> None:
    processes = GALLERY["Processes"]()
    timer = threading.Timer(0.3, processes.close)
    timer.start()
    for _ in range(2):  # the first one is killed, the second one never begins
        with pytest.raises(InterruptedError):
            processes.run(SLEEP, 60.0)
    timer.join()


@cache
def header() -> dict[str, Any]:
    """Return the numbers of the C++ side, as ``problem.h`` says them, by their names there."""
    text = re.sub(r"//.*", "", (cpp.SOURCES / "problem.h").read_text(encoding="utf-8"))
    found = re.findall(r"constexpr \w+ P_(\w+)(?:\[\d*\])* = ([^;]+);", text)
    brackets = str.maketrans("{}", "[]")
    return {
        name: json.loads(re.sub(r",\s*\]", "]", value.translate(brackets))) for name, value in found
    }


@cache
def versus(name: str, *overrides: str) -> PlanningTask:
    return ours.load(name, *overrides)


@pytest.mark.parametrize("name", PROBLEMS)
def test_both_sides_of_the_comparison_have_the_same_problem(name: str) -> None:
    problem, said = (
        versus(name),
        {key.removeprefix(f"{name.upper()}_"): value for key, value in header().items()},
    )
    integration = problem.scenario.integration
    assert (integration.step, integration.substeps) == (said["STEP"], said["SUBSTEPS"])
    assert (integration.method, integration.truth) == ("rk4", "discrete")
    assert problem.start.tolist() == said["START"]
    assert problem.weights.tolist() == said["WEIGHT"]
    assert problem.goal.together
    assert problem.goal.targets.tolist() == said["GOAL"]
    weights = np.array(said.get("GOAL_WEIGHT", [1.0, 1.0]))
    assert problem.goal.tolerances * weights == pytest.approx(said["GOAL_RADIUS"], abs=1e-15)
    limited = np.isfinite(problem.bounds[:, 0])
    assert problem.bounds[limited].T.tolist() == [said["LOWER"], said["UPPER"]]
    assert (limited == ~problem.circular).all()
    span = np.diff(problem.model.control_bounds).ravel() / 2
    assert span == pytest.approx(said["INPUT"], abs=1e-12)
    boxes = [[*entry.position, *entry.box] for entry in problem.scenario.world.obstacle]
    assert boxes == said["BOXES"]


def test_both_sides_of_the_comparison_move_the_same_bodies() -> None:
    (coin,), said = versus("disk").bodies[0].shapes, header()
    assert (coin.radius, coin.thickness) == (said["DISK_RADIUS"], said["DISK_THICKNESS"])
    (load,) = next(body for body in versus("crane").bodies if body.shapes).shapes
    assert (load.x, load.y, load.z) == (said["CRANE_EDGE"],) * 3
    for name, x in (("disk", [1, 2, 0.3, 4, 0, 0]), ("crane", [3, 2, 0.4, 0, 0, 0])):
        pose = versus(name).frames(np.array(x, dtype=float))[0].reshape(3, 4)
        assert pose[:, 3] == pytest.approx(cpp_place(name, x), abs=1e-12)


def test_like_against_like_has_the_settings_of_the_other_side() -> None:
    assert AS_IN_OMPL["min_steps"] == header()["MIN_STEPS"]
    assert AS_IN_OMPL["max_steps"] == header()["MAX_STEPS"]
    planner: Any = ours.make(Entrant(KINOLAB, "rrt_fast", "RRT"))
    assert (planner.goal_connection_period, planner.control_samples, planner.goal_bias) == (
        0,
        1,
        0.05,
    )
    assert ours.make(Entrant(KINOLAB, "rrt_fast")) == type(planner)()


def cpp_place(name: str, x: list[float]) -> list[float]:
    """Return where ``baseline.cpp`` puts the body's centre."""
    if name == "disk":
        return [x[0], x[1], header()["DISK_RADIUS"]]
    height = header()["CRANE_HEIGHT"]
    return [x[0] + x[1] * np.sin(x[2]), 0.0, height - x[1] * np.cos(x[2])]


def cpp_disk(x: Any, u: Any) -> Any:
    """Return the state derivatives (N, 6) that ``baseline.cpp`` writes by hand."""
    said = header()
    psi, psi_dot, phi_dot = x[:, 2], x[:, 4], x[:, 5]
    speed = said["DISK_RADIUS"] * phi_dot
    inertia = said["DISK_ROLL_INERTIA"] + said["DISK_MASS"] * said["DISK_RADIUS"] ** 2
    steered = u[:, 1] / said["DISK_TURN_INERTIA"]
    columns = [speed * np.cos(psi), speed * np.sin(psi), psi_dot, phi_dot, steered]
    return np.column_stack([*columns, u[:, 0] / inertia])


def cpp_crane(x: Any, u: Any) -> Any:
    """Return the state derivatives (N, 6), inputs as there: the rope's without the weight."""
    said = header()
    _, length, theta, x_dot, l_dot, theta_dot = x.T
    load, gravity, s, c = said["CRANE_LOAD"], said["CRANE_GRAVITY"], np.sin(theta), np.cos(theta)
    along = -(load * gravity + u[:, 1])
    trolley = (u[:, 0] - s * along) / said["CRANE_TROLLEY"]
    hoisted = along / load - s * trolley + length * theta_dot**2 + gravity * c
    swung = -(2 * l_dot * theta_dot + c * trolley + gravity * s) / length
    return np.column_stack([x_dot, l_dot, theta_dot, trolley, hoisted, swung])


@pytest.mark.parametrize("name", PROBLEMS)
def test_equations_by_hand_and_derived_ones_agree(name: str) -> None:
    problem, random = versus(name), np.random.default_rng(0)
    x = random.uniform(*problem.sampling_bounds.T, size=(200, 6))
    u = random.uniform(*problem.model.control_bounds.T, size=(200, 2))
    by_hand = {"disk": cpp_disk, "crane": cpp_crane}[name]
    middle = problem.model.control_bounds.mean(axis=1)  # there inputs count from it
    difference = by_hand(x, u - middle) - problem.model.f(x, u)
    assert np.abs(difference).max() < 1e-9  # SI; rounding alone, of numbers up to about 100


def held(*rows: tuple[int, float, float]) -> Any:
    """Return inputs per step from (steps, drive, steer)."""
    return np.array([u for steps, *u in rows for _ in range(steps)])


def test_the_verdict_refuses_a_way_through_a_wall() -> None:
    """It has rolled 1/3 m in 0.5 s, goes on at 4/3 m/s and meets the wall at x = 2.95 m."""
    fault = Judge(versus("disk")).at_knots(held((10, 1.0, 0.0), (60, 0.0, 0.0)))
    assert fault == "at t = 1.75 s coin touches box 5"  # the first knot after 1.71 s


def test_the_verdict_refuses_limits_and_a_missed_goal() -> None:
    judge = Judge(versus("disk"))
    assert judge.at_knots(held((30, 1.0, 0.0))) == "at t = 1.15 s phi_dot is 12.2667"
    assert judge.at_knots(held((1, 1.1, 0.0))) == "an input passes its limit"
    assert "tolerances from the goal" in judge.at_knots(held((1, 0.0, 0.0)))
    assert Judge(versus("disk", "goal.x=1.0", "goal.y=1.0")).at_knots(held((1, 0.0, 0.0))) == ""


def test_the_verdict_looks_between_knots() -> None:
    """The coin backs up by 8.9 mm and turns back in the midst of a step; 8.8 mm are free."""
    judge = Judge(versus("disk", "world.bounds.x=[0.9912, 10]", "goal.x=1.0", "goal.y=1.0"))
    u = held((1, -1.0, 0.0), (5, 0.6, 0.0))
    assert judge.at_knots(u) == ""
    assert judge.between(u) == "at t = 0.13 s x is 0.99112"


@pytest.mark.parametrize("name", PROBLEMS)
def test_motions_are_what_the_model_makes_step_by_step(name: str) -> None:
    problem, random = versus(name), np.random.default_rng(1)
    u = random.uniform(*problem.model.control_bounds.T, size=(20, 2))
    x = [problem.start]
    for row in u:
        x.append(problem.model.step(x[-1], row, problem.step, method="rk4", substeps=5))
    assert (states_under(problem, u) == np.array(x)).all()


def test_a_ratio_is_that_of_the_best_medians() -> None:
    found = ratio([[8.0] * 5, [6.0] * 5], [[2.0] * 5, [9.0] * 5])
    assert (found.value, found.low, found.high) == (3.0, 3.0, 3.0)


def test_the_interval_of_a_ratio_is_as_wide_as_it_should_be() -> None:
    """The median of n normal times varies by 1.25 sigma / sqrt(n), the ratio by both shares."""
    random = np.random.default_rng(2)
    n, share = 400, 0.1
    slow, quick = (mean * random.normal(1.0, share, n) for mean in (10.0, 2.0))
    found = ratio([slow.tolist()], [quick.tolist()])
    half = 1.96 * 1.2533 * share / np.sqrt(n) * np.sqrt(2) * 5.0
    assert found.low < 5.0 < found.high
    assert found.high - found.low == pytest.approx(2 * half, rel=0.25)  # it varies itself


def found(problem: str, entrant: Entrant, seed: int, cpu: float, **facts: Any) -> Run:
    given = {"solved": True, "wall": cpu, "setup": 0.0, "nodes": 10, "propagations": 20}
    return Run(problem, entrant, seed, cpu=cpu, **given | facts)


RRT, LIKE_RRT = Entrant(OMPL, "RRT"), Entrant(KINOLAB, "rrt_fast", "RRT")


def test_a_search_that_finds_nothing_or_lies_counts_as_the_limit() -> None:
    """The verdict counts as time; what OMPL does not look at is named, and its time counts."""
    runs = [
        found("disk", LIKE_RRT, 1, 1.0, judging_cpu=0.5),
        found("disk", LIKE_RRT, 2, 2.0, between="at t = 1 s x is 11"),
        found("disk", LIKE_RRT, 3, 3.0, at_knots="at t = 1 s coin touches wall"),
        found("disk", LIKE_RRT, 4, LIMIT, solved=False),
    ]
    assert tables.times(runs, LIMIT) == [1.5, 2.0, LIMIT, LIMIT]
    cells = tables.searches(runs, LIMIT).splitlines()[-1].strip("| ").split(" | ")
    assert cells[:4] == ["disk", "kinolab rrt_fast", "as OMPL's RRT", "3/4"]
    assert cells[4] == "1/3, 1 refused at knots, 1 refused between"
    assert cells[5] == "51.0000 / ≥ 100 / ≥ 100"
    (listed,) = tables.refused(runs)
    who = "- disk, kinolab rrt_fast (as OMPL's RRT)"
    assert listed.splitlines()[2:] == [
        f"{who}, at knots: seeds 3; the first one: at t = 1 s coin touches wall",
        f"{who}, between: seeds 2; the first one: at t = 1 s x is 11",
    ]


def test_the_table_of_ratios_compares_like_with_like() -> None:
    runs = [found("disk", RRT, seed, 1.0) for seed in (1, 2, 3)]
    runs += [found("disk", LIKE_RRT, seed, 0.125, judging_cpu=0.125) for seed in (1, 2, 3)]
    *_, last = tables.ratios(runs, LIMIT).splitlines()
    cells = last.strip("| ").split(" | ")
    assert cells[1:4] == [
        "RRT against rrt_fast, as OMPL's RRT",
        "RRT 1.0000",
        "rrt_fast 0.2500",
    ]
    assert cells[4:] == ["4.0", "4.0 to 4.0", "5", "3/3", "3/3"]


def test_sides_take_turns() -> None:
    order = entrants(OMPL_PLANNERS, ["rrt_fast", "kpiece_fast"])
    assert [one.side for one in order[:6]] == [OMPL, KINOLAB] * 3
    assert order[1] == LIKE_RRT
    assert len(order) == 8  # rrt_fast is there twice: with OMPL's settings, and with its own


def test_the_comparison_says_what_is_missing_and_how_to_get_it(tmp_path: Any) -> None:
    done = subprocess.run(
        [sys.executable, str(ROOT / "benchmarks" / "versus_ompl.py"), "--planners", "rrt_fast,no"],
        env=environment(PATH=str(tmp_path)),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    skipped, missing, install = done.stderr.splitlines()
    assert skipped == "skipped: kinolab has no planner no"
    assert missing == "cmake is missing, without which OMPL in C++ cannot be built."
    assert install.startswith("Install: apt-get install -y cmake g++ libompl-dev libfcl-dev")


def study_row(scenario: str, duration: float | None, settings: str = "{}") -> dict[str, Any]:
    """A row of a study: a plan of that duration [s], or none."""
    found = duration is not None
    return {
        "scenario": scenario, "settings": settings, "solved": found, "checked": found or None,
        "duration": duration, "goal_distance": 1e-9 if found else 3.0, "wall": 2.0,
    }  # fmt: skip


def test_durations_are_compared_with_the_best_of_all_runs() -> None:
    """What found nothing is longer than everything; long runs and old ones tell what is best."""
    rows = [
        study_row("maze", 11.2),
        study_row("maze", None),
        study_row("maze", 10.9),
        study_row("maze", 12.0),
    ]
    rows += [study_row("crane", 5.0), study_row("maze", 10.0, '{"planner.improve": 90.0}')]
    known = {"crane": 4.0}
    lines = run_path(str(ROOT / "benchmarks" / "durations.py"))["table"](rows, known).splitlines()
    assert lines[2].startswith("| crane | 1/1 | 1/1 | 1/1 | 5.00 | 5.00 | 5.00 | 4.00 | 0/1 |")
    assert lines[3] == "| maze | 3/4 | 3/3 | 3/3 | 10.90 | 11.60 | inf | 10.00 | 1/4 | 2.0 |"
