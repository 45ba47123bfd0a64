"""What users are given: data with the conveniences that stand above it."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.cli import run
from kinolab.dynamics import System
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.errors import EndpointError, InputError
from kinolab.loading import find_machine
from kinolab.runs import check_run
from tests.support import OPEN, problem_of


def test_a_loaded_problem_keeps_its_conveniences_wherever_it_goes(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN)
    for same in (
        problem,
        pickle.loads(pickle.dumps(problem)),
        replace(problem, start=problem.goal),
    ):
        assert isinstance(same, kinolab.Problem)
        assert isinstance(same.system, System)


def test_every_way_to_a_machine_leads_to_a_system(tmp_path: Path) -> None:
    pendulum = kinolab.systems.get("pendulum")
    (tmp_path / "own.json").write_text(machine_to_json(pendulum), encoding="utf-8")
    changed = pendulum.with_parameters(m=2.0).with_feedback(None).changed(name="other")
    made = (changed, changed.model().system, find_machine(str(tmp_path / "own.json")))
    for system in (*made, find_machine("rolling_disk_maze"), pickle.loads(pickle.dumps(pendulum))):
        assert isinstance(system, System)


def test_a_machine_of_another_class_is_the_same_machine() -> None:
    pendulum = kinolab.systems.get("pendulum", m=3.0)
    again = System.of(pendulum)
    assert again == pendulum
    assert again.parameter_values["m"] == 3.0


TABLE: dict[str, Any] = {
    "system": {"name": "rolling_disk"},
    "world": {"bounds": {"x": [-5, 5], "y": (-5.0, 5.0)}, "ground": "plane"},
    "start": {"x": -1.0},
    "goal": {"x": 0.0, "y": 0.0, "tolerance": 0.5},
    "planner": {"name": "rrt", "time_limit": 20.0, "improve": 0},
}


def test_a_table_is_the_scenario_that_its_file_would_be(tmp_path: Path) -> None:
    read, given = problem_of(tmp_path, OPEN), kinolab.load({**TABLE, "title": "A coin on a table"})
    assert given.scenario == read.scenario
    assert given.start.tolist() == read.start.tolist()
    assert given.bounds.tolist() == read.bounds.tolist()


def test_a_table_takes_arrays_and_a_machine_as_an_object() -> None:
    limits = {"x": np.array([-5, 5]), "y": np.array([-5, 5])}
    heavy = kinolab.systems.get("rolling_disk", m=3.0)
    problem = kinolab.load({**TABLE, "system": heavy, "world": {"bounds": limits}})
    assert problem.system == heavy
    assert problem.bounds[0].tolist() == [-5.0, 5.0]
    again = pickle.loads(pickle.dumps(problem)).replace(**{"system.parameters.m": 2.0})
    assert again.system.parameter_values["m"] == 2.0
    assert again.replace({"system": {"name": "diff_drive"}}).machine.name == "diff_drive"


def test_mistakes_in_a_table_say_where_they_stand() -> None:
    with pytest.raises(InputError) as caught:
        kinolab.load({**TABLE, "start": {"z": 1}, "goal": {"x": "far"}, "sytem": 1})
    text = str(caught.value)
    assert 'scenario [goal] x: "far" is text, not a number.' in text
    assert "scenario [start] z: no coordinate or rate is called 'z'." in text
    assert "scenario sytem: no key is called 'sytem'. Did you mean 'system'?" in text


def test_what_is_no_scenario_is_named() -> None:
    with pytest.raises(InputError, match=r"^load source: it is None\. Give a text or a path or"):
        kinolab.load(None)  # type: ignore[arg-type]


def test_a_problem_is_changed_by_the_keys_of_its_scenario() -> None:
    problem = kinolab.load(TABLE)
    other = problem.replace(
        {"start.x": 1, "goal.tolerance": {"x": 0.1}}, planner={"name": "est", "seed": 5}
    )
    assert isinstance(other, kinolab.Problem)
    assert (problem.start[0], other.start[0]) == (-1.0, 1.0)
    assert other.goal.tolerances.tolist() == [0.1, 0.1]
    assert (other.scenario.planner.name, other.scenario.planner.seed) == ("est", 5)
    assert other.replace(**{"goal.tolerance": 0.5}).scenario.goal == problem.scenario.goal


def test_another_planner_does_not_inherit_settings() -> None:
    problem = kinolab.load(TABLE).replace(**{"planner.goal_region_scale": 2.0})
    assert problem.scenario.planner.settings == {"goal_region_scale": 2.0}
    assert problem.replace(**{"planner.name": "potential_field"}).scenario.planner.settings == {}


@pytest.mark.parametrize(
    ("key", "value", "answer"),
    [
        ("start.z", 1.0, "replace start.z: no coordinate or rate is called 'z'."),
        ("start.x", "far", 'replace start.x: "far" is text, not a number.'),
        ("world.obstacle.1.box", 1, "replace world.obstacle.1.box: world.obstacle has no entry 1"),
        ("start..x", 1, "replace start..x: it is not a dotted key. Write it as start.x."),
    ],
)
def test_a_change_that_cannot_be_made_is_named(key: str, value: object, answer: str) -> None:
    with pytest.raises(InputError) as caught:
        kinolab.load(TABLE).replace(**{key: value})
    assert str(caught.value).startswith(answer)


def test_an_obstacle_stands_in_the_way() -> None:
    problem = kinolab.load(TABLE)
    blocked = problem.with_obstacle("pillar", cylinder=(0.2, 1.0), position=(-1.0, 0.0, 0.5))
    assert [o.name for o in blocked.world.obstacles] == ["pillar"]
    assert not problem.world.obstacles
    with pytest.raises(EndpointError, match=r"coin is inside pillar|coin touches pillar"):
        blocked.solve()
    two = blocked.with_obstacle(box=[1, 1, 1], position=[3, 3, 0.5])
    assert [o.name for o in two.world.obstacles] == ["pillar", "box 2"]


@pytest.mark.parametrize(
    ("shape", "answer"),
    [
        ({}, "with_obstacle: none of mesh, box, sphere, cylinder, capsule, map, cloud and run"),
        ({"box": 1.0}, "with_obstacle: 1.0 is not a list. Give a list of three positive numbers"),
        ({"box": [1, 1, 1], "sphere": 2}, "with_obstacle: box and sphere are given together."),
        ({"sphere": 1.0, "colour": 1}, "with_obstacle: no key is called 'colour'."),
        ({"mesh": "/a.stl"}, 'with_obstacle: "/a.stl" does not lead to a file below'),
    ],
)
def test_an_obstacle_that_is_none_is_refused(shape: dict[str, Any], answer: str) -> None:
    with pytest.raises(InputError) as caught:
        kinolab.load(TABLE).with_obstacle(**shape)
    assert str(caught.value).startswith(answer)


def test_a_problem_is_shown_in_a_line() -> None:
    assert repr(kinolab.load(TABLE)) == "<Problem scenario: rolling_disk, 0 obstacles>"


@pytest.fixture(scope="module")
def coin() -> kinolab.Problem:
    return kinolab.load(TABLE)


@pytest.fixture(scope="module")
def solved(coin: kinolab.Problem) -> kinolab.Plan:
    return coin.solve(seed=1, max_iterations=20_000)


@pytest.mark.parametrize(
    ("arguments", "answer"),
    [
        ({"improve": -1}, "solve improve: -1 is too small. Give a number that is not negative [s]"),
        ({"seed": "a"}, 'solve seed: "a" is not a whole number.'),
        ({"seed": -1}, "solve seed: -1 is too small."),
        ({"time_limit": "5"}, 'solve time_limit: "5" is text, not a number.'),
        ({"time_limit": -1.0}, "solve time_limit: -1.0 is too small."),
        ({"max_iterations": 0.5}, "solve max_iterations: 0.5 is not a whole number."),
        ({"planner": 3}, "solve planner: 3 is not text in quotes."),
        ({"planner": "rrrt"}, "[planner] name: no planner is called 'rrrt'. Did you mean 'rrt'?"),
        ({"jobs": "a"}, "solve jobs: it is 'a'. Give a whole number."),
        ({"jobs": 0}, "solve jobs: 0 processes cannot search. Give 1 or more."),
        ({"improv": 3}, "[planner] improv: no setting of rrt is called 'improv'."),
    ],
)
def test_an_argument_of_solve_that_does_not_fit_is_named(
    arguments: dict[str, Any], answer: str, coin: kinolab.Problem
) -> None:
    with pytest.raises(InputError) as caught:
        coin.solve(**arguments)
    assert str(caught.value).startswith(answer)


def test_solve_improves_as_long_as_it_is_told(coin: kinolab.Problem, solved: kinolab.Plan) -> None:
    """The scenario says 0, so that the motion stays as the search found it."""
    assert solved.trajectory is not None
    better = coin.solve(seed=1, max_iterations=20_000, improve=0.5)
    assert better.goal_distance < 1e-6 < solved.goal_distance
    busy = coin.replace(**{"planner.improve": 0.5})
    same = busy.solve(seed=1, max_iterations=20_000, improve=0)
    assert same.trajectory is not None
    assert same.trajectory.x.tobytes() == solved.trajectory.x.tobytes()


def test_a_plan_is_printed_in_ten_lines(solved: kinolab.Plan) -> None:
    lines = str(solved).splitlines()
    assert lines[0] == "solved: Found a trajectory into the goal region."
    assert 6 <= len(lines) <= 10
    assert "rolling_disk in scenario, planner rrt, seed 1" in str(solved)
    assert "knots of x, y, psi, phi, psi_dot, phi_dot" in str(solved)
    assert repr(solved).startswith("<Plan solved: rrt, seed 1, motion of ")


def test_a_plan_that_was_not_found_is_printed(coin: kinolab.Problem) -> None:
    nothing = coin.replace(**{"start.x": 4.0}).solve(max_iterations=1)
    assert 2 <= len(str(nothing).splitlines()) <= 10


def test_a_saved_plan_is_read_back_to_the_last_bit(solved: kinolab.Plan, tmp_path: Path) -> None:
    folder = solved.save(str(tmp_path / "run"))
    run = kinolab.read_run(folder)
    assert solved.trajectory is not None
    assert run.trajectory.x.tobytes() == solved.trajectory.x.tobytes()
    assert run.trajectory.u.tobytes() == solved.trajectory.u.tobytes()
    assert run.report["status"] == "solved"
    assert isinstance(run.problem, kinolab.Problem)
    assert kinolab.verify(run.problem, run.trajectory).passed
    assert check_run(folder).passed


def test_a_machine_that_was_an_object_is_saved_with_its_plan(tmp_path: Path) -> None:
    heavy = kinolab.systems.get("rolling_disk", m=3.0)
    plan = kinolab.load({**TABLE, "system": heavy}).solve(max_iterations=20_000)
    run = kinolab.read_run(plan.save(tmp_path / "run"))
    assert run.problem.system.parameter_values["m"] == 3.0
    assert check_run(run.folder).passed


def test_a_plan_without_a_problem_cannot_be_saved(solved: kinolab.Plan, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^save: this plan does not know its problem\."):
        replace(solved, problem=None).save(tmp_path)
    with pytest.raises(InputError, match=r"^save folder: it is 3\. Give a text or a path\.$"):
        solved.save(3)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="there is no such folder"):
        kinolab.read_run(tmp_path / "nowhere")


def test_what_is_asked_about_something_else_is_named(solved: kinolab.Plan) -> None:
    problem, motion = solved.problem, solved.trajectory
    assert problem is not None
    model = kinolab.systems.get("rolling_disk").model()
    wrong: dict[str, Callable[[], object]] = {
        "verify trajectory: it is <Plan solved": lambda: kinolab.verify(problem, solved),  # type: ignore[arg-type]
        "verify problem: it is None. Give a problem": lambda: kinolab.verify(None, solved),  # type: ignore[arg-type]
        "diagnose plan: it is a Trajectory.": lambda: kinolab.diagnose(problem, motion),  # type: ignore[arg-type]
        "no system is called '3'.": lambda: kinolab.systems.get(3),  # type: ignore[arg-type]
        "x is not made of numbers.": lambda: model.f("coin", [0, 0]),
        "u is not made of numbers.": lambda: model.f(np.zeros(6), "full"),
        "dt is not made of numbers.": lambda: model.step(np.zeros(6), [0, 0], "long"),  # type: ignore[arg-type]
    }
    for answer, call in wrong.items():
        with pytest.raises(InputError) as caught:
            call()
        assert str(caught.value).startswith(answer)


@pytest.mark.parametrize(
    ("text", "answer"),
    [
        ('Torque("t", on=b, about="z", limit=1.0)', "Torque 't' about: it is 'z'. Give an axis of"),
        ('Torque("t", on="arm", about=f.z, limit=1.0)', "Torque 't' on: it is 'arm'. Give a Body."),
        ('Body("c", (0, 0, 1), mass=1.0)', "Body 'c' frame: it is (0, 0, 1). Give a frame, such"),
    ],
)
def test_a_machine_with_a_mistake_is_an_input_error_of_the_command_line(
    text: str, answer: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    body = 'from kinolab.dynamics import *\nf = rot_z(angle("a"))\nb = Body("b", f, mass=1.0)\n'
    file = tmp_path / "machine.py"
    file.write_text(f"{body}def machine():\n    return {text}\n", encoding="utf-8")
    assert run(["equations", str(file)]) == 2
    said = capsys.readouterr().err
    assert answer in said
    assert "mistake in kinolab" not in said


def test_a_machine_in_a_table_may_be_its_name_alone() -> None:
    named = {**TABLE, "system": "rolling_disk"}
    assert kinolab.load(named).system.name == "rolling_disk"
    with pytest.raises(InputError, match="rolling_disc"):
        kinolab.load({**TABLE, "system": "rolling_disc"})


CRATE = {"name": "crate", "box": [1, 1, 1], "position": [3, 2, 0.5]}


@pytest.mark.parametrize("name", ["crate", '"box 2"'])
def test_an_obstacle_is_changed_by_its_name(name: str) -> None:
    """Those that a scenario does not name have a name, too, as messages call them."""
    crates = [CRATE, {"box": [1, 1, 1], "position": [3, 4, 0.5]}]
    problem = kinolab.load(
        {**TABLE, "world": {"bounds": {"x": [-5, 5], "y": [-5, 5]}, "obstacle": crates}}
    )
    moved = problem.replace({f"world.obstacle.{name}.position": [1, 3, 0.5]})
    place = [obstacle.vertices.mean(axis=0).tolist() for obstacle in moved.world.obstacles]
    assert place.count([1.0, 3.0, 0.5]) == 1
    with pytest.raises(InputError, match=r"no entry crat; it has 2.*or are called crate, box 2"):
        problem.replace({"world.obstacle.crat.position": [1, 3, 0.5]})


@pytest.mark.parametrize("name", ["rolling_disk_maze", "satellite_pointing"])
def test_a_start_may_be_a_state(name: str) -> None:
    """Numbers and attitudes alike; what is no state is told with the names of the entries."""
    problem = kinolab.load(name)
    moved = np.array(problem.start)
    moved[:4] = [0.1, 0.7, -0.1, 0.7]
    assert np.abs(problem.replace(start=moved).start - moved).max() < 1e-15
    with pytest.raises(InputError, match=r"start \(.*\): it has shape \(2,\)"):
        problem.replace(start=[1.0, 2.0])


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("time_limt", "time_limit"),
        ("anytim", "anytime"),
        ("goal_regoin_scale", "goal_region_scale"),
    ],
)
def test_an_unknown_argument_of_solve_is_met_by_the_nearest_one(given: str, meant: str) -> None:
    with pytest.raises(InputError, match=f"Did you mean '{meant}'"):
        kinolab.load(TABLE).solve(**{given: 1})


def test_what_one_looks_at_is_shown_on_a_line() -> None:
    """The description of an arm has three million characters."""
    problem = kinolab.load("rolling_disk_maze")
    arm = kinolab.systems.get("panda")
    for shown in (arm, problem.model, problem.system, *problem.world.obstacles):
        assert "\n" not in repr(shown)
        assert len(repr(shown)) < 400
    assert repr(problem.system).startswith("<System rolling_disk: of x, y, psi, phi; driven by ")
