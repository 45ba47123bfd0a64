"""The whole diagnosis: for every planner, on file, in words, and over at once when interrupted."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import kinolab
from kinolab import cli, planners
from kinolab.analyze.diagnose import diagnosis
from kinolab.analyze.diagnose.narrow_passage import passage as narrow_passage
from kinolab.analyze.diagnose.verification_summary import verification_sentences
from kinolab.errors import KinolabError
from kinolab.planners import auto
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import resimulate
from kinolab.solve import PlanResult
from tests.analyze.diagnose.scenarios import PENDULUM, door, ring
from tests.cli.test_cli import interrupted, started
from tests.conftest import Solved
from tests.support import OPEN, problem_of

Array = NDArray[np.float64]
Capture = pytest.CaptureFixture[str]

KINDS = ("auto", "rrt_fast", "prm", "potential_field", "shooting", "syclop_rrt")  # one of each
every_planner = pytest.mark.parametrize(
    "name",
    [
        name if name in KINDS else pytest.param(name, marks=pytest.mark.long)
        for name in planners.names()
    ],
)
LONGEST = 31.0  # [s]: 30 more than is given, for a machine that does other things too


@pytest.fixture
def hurried(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave little time to the looks that take long; they have tests of their own."""
    monkeypatch.setattr(diagnosis, "PASSAGE_SECONDS", 0.1)
    monkeypatch.setattr(diagnosis, "TOTAL_SECONDS", 0.8)


FEW = {"prm": 10, "potential_field": 10, "shooting": 2}  # iterations of those that take long ones


@every_planner
@pytest.mark.usefixtures("hurried")
def test_every_planner_is_told_what_was_in_its_way(name: str, tmp_path: Path) -> None:
    problem = problem_of(tmp_path, ring(1.0), "start.x=-1.5", "goal.tolerance=0.3")
    most = FEW.get(name, 1000)
    found = problem.solve(planner=name, seed=1, time_limit=2.0, max_iterations=most)
    why = kinolab.diagnose(problem, found, max_iterations=20)
    assert found.status in {"approximate", "not_found"}
    assert why.passage is not None
    assert not why.passage.open
    assert any(sentence.startswith("No way was found ") for sentence in why.sentences)
    assert sum(sum(shares.values()) for shares in why.rejections.values()) <= 1.0 + 1e-9
    # Those refuse no motions: they bend them until they fit, or fail.
    if name not in {"shooting", "kinematic_first"}:
        assert any("collision, coin – wall " in sentence for sentence in why.sentences)
    assert any(sentence.startswith(("The nearest", "Nothing")) for sentence in why.sentences)


@every_planner
def test_a_plan_that_was_found_needs_no_diagnosis(name: str, table: kinolab.Problem) -> None:
    found = table.solve(planner=name, seed=1, max_iterations=20_000)
    why = kinolab.diagnose(table, found)
    assert why.sentences == ("The plan was found and verified: nothing stopped it.",)
    assert (why.retries, why.passage) == ((), None)
    assert all(entry.reached for entry in why.approach)


def test_the_narrow_door_comes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The look for a way ends by its number of looks here, for the machine may be busy.

    Three ways of a robot that is 4 cm narrower are enough to find a door that lacks 2 cm.
    """
    monkeypatch.setattr(narrow_passage, "SLIMMER", {80: 3})
    monkeypatch.setattr(narrow_passage, "MAX_CHECKS", 10_000)
    monkeypatch.setattr(diagnosis, "PASSAGE_SECONDS", 120.0)
    monkeypatch.setattr(diagnosis, "TOTAL_SECONDS", 1.0)  # nothing is tried again after it
    problem = problem_of(tmp_path, door(0.35))
    found = problem.solve(seed=1, max_iterations=1000)
    said: list[str] = []
    why = kinolab.diagnose(problem, found, progress=said.append)
    assert why.sentences[0].startswith("The way is about 2 cm too narrow: ")
    assert said[0] == "looking at start and goal"


@pytest.mark.usefixtures("hurried")
@pytest.mark.parametrize(
    ("planner", "other"),
    [
        ("rrt_fast", "--planner auto, in which kpiece_fast and rrt_fast take turns"),
        ("auto", "--planner kpiece_fast or rrt_fast, which then has all of the time"),
    ],
)
def test_where_nothing_is_in_the_way_the_last_word_is_what_to_try(
    planner: str, other: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An open table, and a search of a single iteration within 20 s; both are given four times."""
    monkeypatch.setattr(auto, "FLAT_ITERATIONS", 0)  # a straight line would solve it
    problem = problem_of(tmp_path, OPEN, "planner.max_iterations=1", "goal.tolerance=0.1")
    found = problem.solve(planner=planner, seed=1)
    why = kinolab.diagnose(problem, found)
    assert why.retries
    assert not any(retry.solved for retry in why.retries)
    assert why.sentences[-1].startswith(
        "Nothing that was looked at rules a plan out: search longer"
    )
    assert "(--time-limit 80 --max-iterations 4), or with another planner" in why.sentences[-1]
    assert other in why.sentences[-1]


@pytest.mark.usefixtures("hurried")
def test_a_diagnosis_prints_its_sentences(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN)
    why = kinolab.diagnose(problem, problem.solve(seed=1, max_iterations=1))
    assert str(why).splitlines() == list(why.sentences)
    assert repr(why) == f"<Diagnosis: {why.sentences[0]}>"


def test_the_iterations_of_its_searches_can_be_given(tmp_path: Path) -> None:
    """One iteration does not cross the table, 20 000 do, though the plan's search made one."""
    problem = problem_of(tmp_path, OPEN, "goal.tolerance=0.1")
    found = problem.solve(planner="rrt_fast", seed=1, max_iterations=1)
    few = kinolab.diagnose(problem, found, max_iterations=1)
    many = kinolab.diagnose(problem, found, max_iterations=20_000)
    assert not any(retry.solved for retry in few.retries)
    assert any(retry.solved for retry in many.retries)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"max_iterations": 0}, "diagnose max_iterations: 0 is no number of iterations. Give 1"),
        ({"time_limit": 2.0}, "diagnose time_limit: it is an argument of solve. A diagnosis takes"),
        ({"seed": 2}, "diagnose seed: it is an argument of solve. The plan's seed is taken again"),
    ],
)
def test_what_means_nothing_to_a_diagnosis_is_refused_with_what_would_work(
    arguments: dict[str, float], words: str, tmp_path: Path
) -> None:
    problem = problem_of(tmp_path, OPEN)
    found = problem.solve(seed=1, max_iterations=1)
    with pytest.raises(KinolabError) as refused:
        kinolab.diagnose(problem, found, **arguments)
    assert words in str(refused.value)


def test_a_diagnosis_ends_in_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A fifteenth of the time that it has: its searches alone would take longer."""
    monkeypatch.setattr(diagnosis, "PASSAGE_SECONDS", 0.6)
    monkeypatch.setattr(diagnosis, "TOTAL_SECONDS", 1.0)
    problem = problem_of(tmp_path, door(0.35))
    why = kinolab.diagnose(problem, problem.solve(seed=1, time_limit=0.1))
    assert why.seconds < LONGEST
    assert why.passage is not None
    assert not why.passage.open


@pytest.mark.usefixtures("hurried")
def test_a_motion_that_truth_refuses_is_called_that(short: Solved) -> None:
    """A plan whose statistics tell that the truth missed the goal twice."""
    found = replace(short.plan, status="approximate", statistics={"missed_the_goal_in_truth": 2.0})
    assert any(
        sentence.startswith("The planner's steps reached the goal 2 times where the true motion")
        for sentence in kinolab.diagnose(short.problem, found).sentences
    )


@pytest.mark.usefixtures("hurried")
def test_motions_that_break_in_truth_are_not_said_to_miss_the_goal(short: Solved) -> None:
    found = replace(short.plan, status="approximate", statistics={"broken_in_truth": 1.0})
    [sentence] = [s for s in kinolab.diagnose(short.problem, found).sentences if "truth" in s]
    assert sentence.startswith("The planner reached the goal once by a motion that in truth")
    assert "step" not in sentence


def refusal_of(problem: PlanningTask, t: Array, u: Array) -> str:
    """Return what is said of a motion under given inputs that the verifier refuses."""
    motion = resimulate(problem, t, u)
    certificate = kinolab.verify(problem, motion)
    assert not certificate.passed
    found = PlanResult("verification_failed", motion, certificate, "rrt", 1, 10, 0.0)
    [sentence] = verification_sentences(problem, found)
    return sentence


def test_a_plan_that_was_not_verified_names_the_checks(short: Solved, tmp_path: Path) -> None:
    """Its steps are those of the truth, so that shorter ones would not help."""
    problem = problem_of(tmp_path, OPEN, "bounds.phi_dot=[-0.1, 0.1]")
    said = refusal_of(problem, short.trajectory.t, short.trajectory.u)
    assert said.startswith("Verification refused the motion found (limits: at t = ")
    assert "phi_dot is " in said
    assert "[integration]" not in said


@pytest.mark.parametrize(("tolerance", "to_blame"), [(0.1, True), (1e-9, False)])
def test_the_step_is_to_blame_where_the_planners_own_motion_passes(
    tolerance: float, to_blame: bool, tmp_path: Path
) -> None:
    """Straight on at 8/3 m/s^2 for 1 s: 4/3 m in truth.

    Euler's steps h go h/2 = 0.1 s of the last speed less far: 4/3 - 4/15 m, or 16/15 rad of a
    coin of 0.25 m. The goal is 0.05 m further than that: they end within its tolerance, or neither
    does.
    """
    goal = 4 / 3 - 4 / 15 + 0.05
    problem = problem_of(
        tmp_path,
        OPEN,
        'integration={method="euler", step=0.2}',
        f"goal={{x={goal - 1.0}, tolerance={tolerance}}}",
    )
    said = refusal_of(problem, np.linspace(0.0, 1.0, 6), np.array([[1.0, 0.0]] * 5))
    assert said.startswith("Verification refused the motion found (goal: x is off by 0.2167)")
    assert said.endswith(
        ", which the planner's own steps pass. They lead up to 1.07 rad (phi) away from the true "
        "motion: shorten [integration] step."
        if to_blame
        else "."
    )
    assert ("[integration]" in said) == to_blame


def test_the_data_are_plain_and_finite(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, PENDULUM)
    found = problem.solve(seed=1, max_iterations=5)
    data = kinolab.diagnose(problem, found).to_json()
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    assert data["start_clearance"]["clearance"] is None  # there is nothing around
    assert data["passage"] is None
    assert data["goal_held"]["needed"]["torque"] == pytest.approx(9.81, rel=1e-3)
    assert any(math.isclose(entry["target"], math.pi / 2) for entry in data["approach"])


# --- on the command line ---

SPARING = ["--max-iterations", "100", "--no-animation", "--quiet"]


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ring.toml").write_text(ring(1.0).replace("x = -1.0", "x = -2.0"))
    return tmp_path


@pytest.mark.usefixtures("hurried")
def test_the_findings_are_printed_and_on_file(home: Path, capsys: Capture) -> None:
    assert cli.run(["ring.toml", *SPARING]) in {3, 4}
    out = capsys.readouterr().out
    report = json.loads((home / "runs" / "ring" / "report.json").read_text())
    sentences = report["diagnosis"]["sentences"]
    assert sentences
    assert all(f"  {sentence}\n" in out for sentence in sentences)
    assert {"rejections", "approach", "passage", "retries"} <= set(report["diagnosis"])
    assert (home / "runs" / "ring" / "trajectory.csv").is_file() == (report["cost"] is not None)


@pytest.mark.usefixtures("hurried")
def test_the_findings_are_part_of_the_json(home: Path, capsys: Capture) -> None:
    cli.run(["ring.toml", *SPARING, "--json"])
    printed = json.loads(capsys.readouterr().out)
    report = json.loads((home / "runs" / "ring" / "report.json").read_text())
    assert {"folder": printed["folder"], **report} == printed


def test_the_diagnosis_can_be_left_out(home: Path, capsys: Capture) -> None:
    cli.run(["ring.toml", *SPARING, "--no-diagnosis"])
    report = json.loads((home / "runs" / "ring" / "report.json").read_text())
    assert set(report["diagnosis"]) == {"rejections"}
    assert "refused" not in capsys.readouterr().out


@pytest.mark.usefixtures("hurried")
def test_the_nearest_approach_is_written_and_drawn(home: Path) -> None:
    code = cli.run(["ring.toml", "--max-iterations", "300", "--quiet"])
    written = {path.name for path in (home / "runs" / "ring").iterdir()}
    assert code == 4
    assert {"trajectory.csv", "trajectory.npz", "animation.gif"} <= written


@pytest.mark.usefixtures("home")
def test_progress_is_told_on_stderr(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(diagnosis, "PASSAGE_SECONDS", 0.5)
    monkeypatch.setattr(diagnosis, "TOTAL_SECONDS", 6.0)
    cli.run(["ring.toml", "--max-iterations", "20", "--no-animation"])
    printed = capsys.readouterr()
    assert "looking at start and goal" in printed.err
    assert "trying again without the obstacles" in printed.err
    assert "trying again" not in printed.out


@pytest.mark.parametrize(
    ("word", "change"),
    [
        ("looking at start", ()),
        ("looking for a way", ()),
        ("trying again", ("--set", "world.obstacle=[]")),  # with no way to look for before
    ],
    ids=["looking at start", "looking for a way", "trying again"],
)
def test_130_an_interrupted_diagnosis_leaves_the_run_whole(
    word: str, change: tuple[str, ...], home: Path
) -> None:
    process = started("ring.toml", "--max-iterations", "100", "--no-animation", *change, cwd=home)
    seconds, _, err = interrupted(process, word, 0.0)  # what follows takes a moment only
    assert process.returncode == 130, err
    assert seconds < 5.0  # [s]; about 1 on a machine that does nothing else
    assert "Traceback" not in err
    report = json.loads((home / "runs" / "ring" / "report.json").read_text())
    assert set(report["diagnosis"]) == {"rejections"}
    if report["cost"] is not None:
        assert (home / "runs" / "ring" / "trajectory.csv").is_file()


@pytest.mark.usefixtures("home")
def test_an_impossible_start_is_an_error_as_ever(capsys: Capture) -> None:
    assert cli.run(["ring.toml", "--set", "start.x=1.0"]) == 5
    assert "coin touches wall 1." in capsys.readouterr().err
