"""The study of the benchmark judges rightly, loses nothing, and prints what others published."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import kinolab
from benchmarks.dynobench_study import measuring, records, tables, wheel, worker
from benchmarks.dynobench_study.clearance import clearance
from benchmarks.dynobench_study.judgement import centre, official
from benchmarks.dynobench_study.problems import all_problems, chosen, machine_of
from benchmarks.dynobench_study.published import PLANNERS, published
from benchmarks.dynobench_study.records import Improvement, Offline, Run
from benchmarks.dynobench_study.stored import motion_in, replay, solutions
from benchmarks.dynobench_study.strict import miss, strictly
from benchmarks.dynobench_study.summary import summary
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import follow_map
from kinolab.trajectory import Trajectory
from tests.scenario.dynobench.test_environments import written
from tests.scenario.dynobench.wheel import (
    ENVIRONMENTS,
    FOLDER,
    MACHINES,
    ask,
    environment,
    needs_wheel,
)
from tests.support import ROOT
from tests.support import environment as surroundings

SCRIPT = ROOT / "benchmarks" / "dynobench.py"
LIMIT = 20.0  # [s]
GOOD = {"start": 0.0, "goal": 1e-4, "jump": 1e-15, "states": -1.0, "actions": 0.0, "collision": -1}
NAME = "unicycle1_v0/parallelpark_0"  # best published cost: 2.9 s, iDb-A* took 0.1 s


def run(seed: int = 1, seconds: float = 1.0, final: float = 3.0, **facts: object) -> Run:
    motions = (
        Improvement(seconds / 2, 18.0, "search", 0.02),
        Improvement(seconds, 19.0, "repair", 1e-9),
        Improvement(2 * seconds, final, "shorten", 1e-9),
    )
    known = {"improvements": motions, "faults": (), "clearance": 0.03, "official": GOOD}
    return Run(NAME, seed, **known | facts)  # type: ignore[arg-type]


def cells(*runs: Run) -> list[str]:
    *_, last = tables.table(runs, [Offline("unicycle1_v0", (0.5, 0.7, 0.6))], LIMIT).splitlines()
    return last.strip("| ").split(" | ")


def test_a_row_has_our_medians_and_the_published_figures() -> None:
    row = cells(run(1, 1.0, 3.0), run(2, 3.0, 3.2, clearance=0.01), run(3, 2.0, 3.1))
    assert row[:7] == [NAME, "3/3", "3/3", "2.00", "19.00", "3.10", "0.0100"]
    assert row[7:] == ["0.60", "1, 0.1, 3.1, 3.1", "1, 0.1, 3.1, 3.1", "1, 0.1, 4.4, 3", "2.9"]


def test_what_one_of_both_refuses_is_not_solved_and_counts_as_the_limit() -> None:
    refused = run(2, official=GOOD | {"collision": 0.011})
    inexact = run(3, faults=("FAILED goal",))
    row = cells(run(1), refused, inexact)
    assert row[1:5] == ["2/3", "2/3", "≥ 20.00", "19.00"]
    assert cells(Run(NAME, 1, complaint="no motion was found"))[1:7] == [
        *("0/1", "0/1", "≥ 20.00", "–", "–", "–")
    ]


@pytest.mark.parametrize("measure", GOOD)
def test_without_a_number_within_the_tolerance_nothing_is_accepted(measure: str) -> None:
    limit = 0.03 if measure in ("start", "goal") else 0.01
    assert run(official=GOOD | {measure: 0.99 * limit}).accepted
    assert not run(official=GOOD | {measure: limit}).accepted
    assert not run(official=GOOD | {measure: float("nan")}).accepted
    assert not run(official={}).accepted


def test_the_summary_counts_problems() -> None:
    def said(*runs: Run) -> list[str]:
        return [line.rpartition(": ")[2] for line in summary(runs, LIMIT)]

    quick = [run(seed, 0.1, 2.8) for seed in (1, 2, 3)]
    assert said(*quick) == ["1.", "1 of 1.", "1 of 1.", "1 of 1."]
    near = [run(seed, 0.2, 3.0) for seed in (1, 2, 3)]
    assert said(*near) == ["1.", "0 of 1.", "1 of 1.", "0 of 1."]
    shaved = [*quick[:2], run(3, 0.1, 2.8, clearance=0.019)]
    assert said(*shaved) == ["1.", "1 of 1.", "1 of 1.", "0 of 1."]
    failing = [quick[0], Run(NAME, 2), Run(NAME, 3)]
    assert said(*failing) == ["1.", "0 of 1.", "0 of 1.", "0 of 1."]
    assert next(summary(failing, LIMIT)).startswith("Solved with every seed: 0 of 1 problems")


def test_results_survive_a_run_that_is_broken_off(tmp_path: Path) -> None:
    file = tmp_path / "results.jsonl"
    known = [run(1), run(2, official={}, faults=None, clearance=None)]
    records.append(file, {"limit": LIMIT})
    records.append(file, Offline("car1_v0", (0.5,)))
    for one in known:
        records.append(file, one)
    with file.open("a") as half:
        half.write(json.dumps({"run": {"problem": NAME}})[:-5])
    found = records.read(file)
    assert (found.runs, found.offline) == (known, [Offline("car1_v0", (0.5,))])
    assert found.circumstances == {"limit": LIMIT}


def command(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, str(SCRIPT), *map(str, arguments)],
        env=surroundings(),
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_table_is_printed_from_the_results_alone(tmp_path: Path) -> None:
    file = tmp_path / "results.jsonl"
    records.append(file, {"limit": LIMIT, "planner": "auto", "jobs": 2, "on": "a computer"})
    records.append(file, run())
    done = command("--print", "--results", file, "--problems", NAME, "--seeds", 2)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(
        "a computer\n\nPlanner auto, limit 20 s, seeds 1 to 2. 2 runs side"
    )
    assert "1 runs are missing." in done.stdout
    assert f"| {NAME} | 1/1 | 1/1 | 1.00 | 19.00 | 3.00 | 0.0300 |" in done.stdout


@dataclass(frozen=True)
class Ended:
    code: int | None
    stdout: str = ""
    stderr: str = ""


class Pretended:
    """Processes that end as they are told to."""

    def __init__(self, *ended: Ended) -> None:
        self._ended, self.closed = iter(ended), False

    def run(self, command: Sequence[str], limit: float) -> Ended:
        assert command[-4:] == [str(Path("envs") / f"{NAME}.yaml"), NAME, "1", str(LIMIT)]
        assert limit == LIMIT + measuring.GRACE
        return next(self._ended)

    def close(self) -> None:
        self.closed = True


def test_what_hangs_or_crashes_is_a_run_without_a_motion() -> None:
    whole = json.dumps(asdict(run()))
    ends = Ended(0, f"FCL says something\n{whole}\n"), Ended(None), Ended(-11, "{", "a\nfault")
    processes, tasks = Pretended(*ends), [measuring.Task(NAME, 1)] * 3
    found = list(measuring.measure(processes, Path("envs"), tasks, LIMIT, None, jobs=1))
    assert sorted(one.complaint for one in found) == ["", "exit -11 fault", "killed after 140 s"]
    assert [one for one in found if not one.complaint] == [run()]
    assert sum(one.counts for one in found) == 1
    assert processes.closed


@needs_wheel
def test_a_run_finds_a_motion_and_has_it_judged_by_both() -> None:
    """In 3 s for both; the last motion, the shortest, is the one that is judged."""
    found = worker.run(environment(NAME), NAME, 1, 3.0, None)
    assert found.improvements[0].made_by == "search"
    assert found.final is not None
    assert found.final.duration <= found.improvements[0].duration
    assert found.accepted
    assert found.goal is not None
    assert found.goal >= found.official["goal"] - 1e-12
    assert found.strict == (found.goal <= 1e-3)
    assert found.clearance is not None
    assert 0 < found.clearance <= -found.official["collision"] + 1e-6


@needs_wheel
def test_results_of_other_circumstances_are_not_mixed(tmp_path: Path) -> None:
    file = tmp_path / "results.jsonl"
    records.append(file, {"limit": LIMIT, "planner": "auto", "jobs": 1, "on": "a computer"})
    done = command("--results", file)
    assert (done.returncode, "Give --resume, --print or another" in done.stderr) == (2, True)
    done = command("--resume", "--limit", "120", "--results", file)
    assert done.returncode == 2
    assert "results.jsonl has another limit: 20.0." in done.stderr
    done = command("--problems", "car1_v0/kink_1")
    assert done.returncode == 2
    assert "no problem is called car1_v0/kink_1. Known: acrobot_v0/swing_down," in done.stderr


def test_every_problem_has_what_others_published() -> None:
    """Nothing was solved for less than the best, and shares are shares."""
    others = published()
    assert len(others) == 43
    for one in others.values():
        assert tuple(one.by) == PLANNERS
        finals = [who.final for who in one.by.values() if who.final is not None]
        assert one.best <= min(finals)
        assert all(0 <= who.success <= 1 for who in one.by.values())
        assert all((who.time is None) == (who.final is None) for who in one.by.values())


@needs_wheel
def test_the_problems_are_those_of_the_benchmark() -> None:
    assert set(all_problems()) == set(ENVIRONMENTS)
    assert {machine_of(name) for name in all_problems()} == set(MACHINES)
    assert chosen(None, ["quad3d_v0"]) == [n for n in all_problems() if "quadrotor_v0" in n]


@needs_wheel
@pytest.mark.parametrize("machine", MACHINES)
def test_what_is_exact_is_within_a_thousandth_by_the_authors_distance(machine: str) -> None:
    """The two are the same along one axis; elsewhere a Euclidean norm is below a sum."""
    problem = kinolab.load(environment(MACHINES[machine]))
    strict, model = strictly(problem), problem.model
    generator = np.random.default_rng(4)
    states = [centre(problem)]
    for size in np.geomspace(1e-4, 1e-2, 40):
        x = centre(problem) + size * generator.uniform(-1, 1, model.nx)
        for first in model.attitudes.values():
            x[first : first + 4] /= np.linalg.norm(x[first : first + 4])
        states.append(x)
    along = centre(problem)
    along[0] += 9e-4
    states.append(along)
    x = np.array(states)
    y = np.tile(centre(problem), (len(x), 1))
    theirs = ask("distances", machine, environment(MACHINES[machine]), x=x, y=y)["distance"]
    ours = np.array([miss(problem, state) for state in x])
    exact = np.array([strict.goal_excess(state) <= 1 for state in x])
    assert (ours >= theirs - 1e-12).all()
    assert ours[[0, -1]] == pytest.approx(theirs[[0, -1]], abs=1e-12)
    np.testing.assert_array_equal(exact, ours <= 1e-3)
    assert 2 < exact.sum() < len(x)


@needs_wheel
def test_small_turns_that_the_benchmark_overlooks_count_here() -> None:
    """It takes the angle as nothing where its cosine is above 1 - 1e-5: 4.47 mrad."""
    name = "quadrotor_v0/window"
    problem = kinolab.load(environment(name))
    halves = np.array([4.4e-3, 4.6e-3])
    x = np.tile(centre(problem), (2, 1))
    x[:, 3], x[:, 6] = np.sin(halves), np.cos(halves)
    y = np.tile(centre(problem), (2, 1))
    theirs = ask("distances", "quad3d_v0", environment(name), x=x, y=y)["distance"]
    assert theirs == pytest.approx([0.0, 0.5 * halves[1]], abs=1e-9)
    assert [miss(problem, state) for state in x] == pytest.approx(0.5 * halves, rel=1e-9)


def parked(folder: Path, u: list[list[float]]) -> tuple[PlanningTask, Trajectory]:
    """Return a motion of the car with its trailer near a box."""
    problem = kinolab.load(written(folder))
    t, names = problem.step * np.arange(len(u) + 1.0), problem.model
    x = follow_map(problem.model, problem.start, t, np.array(u), "euler").x
    return problem, Trajectory(t, x, np.array(u), names.state_names, names.control_names)


def test_the_clearance_of_a_drive_along_a_box_is_that_of_plane_geometry(tmp_path: Path) -> None:
    """A car 0.25 m wide goes straight past a box of which the face is parallel to its side."""
    problem, motion = parked(tmp_path, [[0.5, 0.0]] * 20)
    tops = [
        entry.position[1] + entry.box[1] / 2
        for entry in problem.scenario.world.obstacle
        if entry.box
    ]
    side = problem.start[1] - 0.25 / 2
    assert clearance(problem, motion) == pytest.approx(side - max(tops), abs=1e-6)


@needs_wheel
def test_a_deep_overlap_is_measured_without_asking_what_may_hang(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It stands in the middle of a wall 0.2 m thick, turned by 0.3 rad."""
    monkeypatch.setattr(wheel, "depth", lambda *_: pytest.fail("FCL was asked"))
    problem = kinolab.load(environment("unicycle1_v0/bugtrap_0"))
    x = np.array([[4.5, 3.0, 0.3], [4.5, 3.0, 0.3]])
    model = problem.model
    motion = Trajectory(
        np.array([0, 0.1]), x, np.zeros((1, 2)), model.state_names, model.control_names
    )
    found = official(environment("unicycle1_v0/bugtrap_0"), problem, motion)
    reach = 0.25 * np.cos(0.3) + 0.125 * np.sin(0.3)  # of the box from its centre, along x
    assert found["collision"] == pytest.approx(reach + 0.1, abs=1e-6)
    assert not replace(run(), official=found).accepted


FIRST = {machine_of(name): (name, file) for name, file in reversed([*solutions(FOLDER / "envs")])}


@needs_wheel
@pytest.mark.parametrize("machine", FIRST)
def test_of_a_stored_solution_both_say_the_same(machine: str) -> None:
    """Two planners' solutions are stored for most problems; the benchmark replays all 71."""
    replayed = replay(FOLDER / "envs", *FIRST[machine])
    assert not replayed.disagreements
    assert all(replayed.theirs[name] < limit for name, limit in records.TOLERANCES.items())


@needs_wheel
def test_the_verifier_sees_the_overlap_that_the_benchmark_allows() -> None:
    """The stored solution of RRT*+TO goes 4.8 mm through a corner of the hole."""
    file = FOLDER / "envs" / "quad2d_v0" / "fall_through" / "rrt_to_v0_solution_v0.yaml"
    replayed = replay(FOLDER / "envs", "quad2d_v0/fall_through", file)
    assert 0 < replayed.theirs["collision"] < 0.01
    assert "collision" in replayed.faults
    assert not replayed.disagreements
    x, u = motion_in(file)
    assert len(x) == len(u) + 1
