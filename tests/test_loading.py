"""From a scenario to a problem: numbers arrive where they belong, mistakes are all told."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import trimesh

import kinolab
from kinolab.dynamics import Body, System, angle, move, rot_y
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.errors import InputError
from kinolab.loading import find_machine, find_scenario, find_system
from kinolab.problem import PlanningTask
from kinolab.scenario import builtin_scenarios
from tests.support import OPEN, needs, problem_of

PENDULUM = 'schema = 1\ntitle = "A pendulum"\n[system]\nname = "pendulum"\n'
MESH = '\n[[world.obstacle]]\nmesh = "meshes/{}"\n'


def mistakes(folder: Path, text: str, *overrides: str) -> list[str]:
    with pytest.raises(InputError) as caught:
        problem_of(folder, text, *overrides)
    return [str(mistake) for mistake in caught.value.mistakes]


# --- what is right ---


@pytest.mark.parametrize("name", builtin_scenarios())
def test_every_scenario_loads_and_its_start_and_goal_have_room(name: str) -> None:
    problem = kinolab.load(name)
    assert problem.name == name
    problem.check_endpoints()


def test_meshes_are_found_where_an_editable_installation_links_scenarios(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """It makes a folder of links, one for each file, and meshes of links there lie elsewhere."""
    installed = builtin_scenarios()["rolling_disk_maze"].parent
    for file in ("rolling_disk_maze.toml", "meshes/rolling_disk_maze.stl"):
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).symlink_to(installed / file)
    monkeypatch.setattr("importlib.resources.files", lambda _: tmp_path)
    assert kinolab.load("rolling_disk_maze").world.obstacles


def test_names_put_numbers_at_their_entries(tmp_path: Path) -> None:
    text = OPEN.replace("[start]\nx = -1.0", "[start]\npsi_dot = 0.5\ny = 2\nphi = 0.25\nx = -1")
    problem = problem_of(tmp_path, text)
    names = problem.model.state_names
    expected = {"x": -1.0, "y": 2.0, "psi": 0.0, "phi": 0.25, "psi_dot": 0.5, "phi_dot": 0.0}
    assert dict(zip(names, problem.start.tolist(), strict=True)) == expected


def test_limits_are_the_narrowest_of_machine_scenario_and_world(tmp_path: Path) -> None:
    limits = ["bounds.x=[-4, 9]", "bounds.psi_dot=[-1, 100]", "bounds.y=[-7, 7]"]
    problem = problem_of(tmp_path, OPEN, *limits)
    bounds = dict(zip(problem.model.state_names, problem.bounds.tolist(), strict=True))
    assert bounds["x"] == [-4.0, 5.0]  # the world ends at 5
    assert bounds["y"] == [-5.0, 5.0]
    assert bounds["psi_dot"] == [-1.0, 4.0]  # the machine ends at 4
    assert bounds["phi_dot"] == [-12.0, 12.0]


def test_a_limit_on_a_rate_that_follows_from_others_is_kept(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "bounds.y_dot=[-0.5, 0.25]")
    rate = problem.model.rate_names.index("y_dot")
    assert problem.rate_bounds[rate].tolist() == [-0.5, 0.25]


def test_a_body_outside_the_world_is_a_violation_though_no_coordinate_says_so(
    tmp_path: Path,
) -> None:
    problem = problem_of(tmp_path, PENDULUM, "world.bounds.x=[0, 2]")
    assert list(problem.limit_violations(np.array([0.0, 0.0]))) == []
    (violation,) = problem.limit_violations(np.array([np.pi, 0.0]))  # the bob is at x = -1
    name, value, *limits = violation
    assert (name, limits) == ("x of bob", [0.0, 2.0])
    assert value == pytest.approx(-1.0)


def test_at_rest_asks_every_free_rate_to_be_zero(tmp_path: Path) -> None:
    goal = problem_of(tmp_path, OPEN, "goal.at_rest=true").goal
    wanted = dict(zip(goal.indices, goal.targets.tolist(), strict=True))
    assert wanted == {0: 0.0, 1: 0.0, 4: 0.0, 5: 0.0}


def test_a_weight_is_the_scenarios_or_one_per_scale(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "metric.psi=0.25")
    weights = dict(zip(problem.model.state_names, problem.weights.tolist(), strict=True))
    assert weights["psi"] == 0.25
    assert weights["phi_dot"] == pytest.approx(1 / 12)  # one over its largest speed


def test_a_parameter_changes_the_machine_and_its_shape(tmp_path: Path) -> None:
    small, large = (
        problem_of(tmp_path, OPEN, f"system.parameters={{ R = {R} }}") for R in (0.25, 0.5)
    )
    x = np.zeros(6)
    assert small.frames(x)[0, 11] == 0.25  # [m] height of the centre
    assert large.frames(x)[0, 11] == 0.5
    accelerations = [problem.model.f(x, [1.0, 0.0])[5] for problem in (small, large)]
    assert accelerations[0] / accelerations[1] == pytest.approx(4)  # 1 / (1.5 m R^2)


def test_overrides_apply_in_their_order(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "start.x=1", "start.x=2", "planner.goal_bias=0.5")
    assert problem.start[0] == 2.0
    assert problem.scenario.planner.settings == {"goal_bias": 0.5}


def test_a_machine_in_a_file_of_its_own_is_the_same_machine(tmp_path: Path) -> None:
    tmp_path.joinpath("coin.py").write_text(
        "from kinolab.systems import get\ndef coin():\n    return get('rolling_disk')\n"
    )
    tmp_path.joinpath("coin.json").write_text(machine_to_json(find_machine("rolling_disk")))
    x, u = np.linspace(-1, 1, 6), np.array([0.3, -0.2])
    expected = problem_of(tmp_path, OPEN).model.f(x, u)
    for file in ("coin.py:coin", "coin.json"):
        text = OPEN.replace('name = "rolling_disk"', f'file = "{file}"')
        assert problem_of(tmp_path, text).model.f(x, u) == pytest.approx(expected, rel=1e-14)


# --- what is wrong ---


def test_an_unknown_scenario_is_told_with_the_nearest_that_exists() -> None:
    with pytest.raises(InputError, match="Did you mean 'rolling_disk_maze'"):
        kinolab.load("rolling_disc_maze")


def test_four_mistakes_of_four_kinds_are_all_told(tmp_path: Path) -> None:
    text = OPEN.replace("tolerance = 0.5", 'tolerance = "wide"')  # a wrong type
    text = text.replace("x = -1.0", "z = -1.0")  # an unknown coordinate
    text = text.replace("time_limit", "time_limits")  # an unknown key
    found = mistakes(tmp_path, text + MESH.format("missing.stl"))  # a missing mesh
    assert len(found) == 4, found
    for words in ("[goal] tolerance", "[start] z", "[planner] time_limits", "missing.stl"):
        assert any(words in mistake for mistake in found), (words, found)


def test_mistakes_in_overrides_and_in_the_file_are_told_together(tmp_path: Path) -> None:
    text = OPEN.replace("x = -1.0", "z = -1.0")
    found = mistakes(tmp_path, text, "goal.w=1", "planner.name=rtt", "integration.step=-1")
    for words in ("[start] z", "--set goal.w=1", "'rrt'", "--set integration.step=-1"):
        assert any(words in mistake for mistake in found), (words, found)


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("start.x_dot=1", "x_dot follows from the other rates"),
        ("goal.y_dot=0", "y_dot follows from the other rates"),
        ("goal.tolerance={ x_dot = 0.1 }", "Give one of psi_dot, phi_dot instead"),
        ("goal.tolerance={ x = 0.1, y_dot = 1e-9 }", "y_dot follows from the other rates"),
        ("metric.x_dot=2", "x_dot follows from the other rates"),
        ("start.psi=[0, 0, 0, 1]", "psi is a single number"),
        ("start.q=1", "'q'"),
        ("bounds.thetta=[0, 1]", "'thetta'"),
        ("metric.xx=1", "'xx'"),
        ("goal.tolerance={ z = 1 }", "'z'"),
        ("system.parameters.radius=1", "'radius'"),
        ("system.name=rolling_disc", "Did you mean 'rolling_disk'"),
        ("planner.goal_biass=0.1", "Did you mean 'goal_bias'"),
        ("planner.goal_bias=high", "does not fit"),
        ("planner.max_steps=2.5", "does not fit"),
        ("planner.max_steps=true", "does not fit"),
        ("start.x=nan", "not finite"),
        ("world.bounds.x=[1, 0]", "low"),
        ("start.x=true", "true"),
    ],
)
def test_a_value_that_cannot_be_is_refused_with_its_place(
    tmp_path: Path, override: str, words: str
) -> None:
    found = mistakes(tmp_path, OPEN, override)
    assert len(found) == 1, found
    assert words in found[0]
    assert f"--set {override}" in found[0]


@pytest.mark.parametrize(
    "override",
    [
        "planner.max_steps=-1",
        "planner.max_steps=0",
        "planner.min_steps=0",
        "planner.min_steps=30",  # more than max_steps
        "planner.goal_bias=7",  # a probability
        "planner.goal_bias=-0.1",
        "system.parameters.R=-1",
    ],
)
def test_a_number_outside_its_range_is_refused(tmp_path: Path, override: str) -> None:
    found = mistakes(tmp_path, OPEN, override)
    assert override.partition("=")[0].rpartition(".")[2] in " ".join(found)


def test_a_position_without_limits_is_told_by_name(tmp_path: Path) -> None:
    found = mistakes(tmp_path, OPEN, "world.bounds={ y = [-5, 5] }")
    assert len(found) == 1
    assert "nothing limits x, so a planner cannot sample it. Write x = [lower, upper]" in found[0]


def test_all_positions_without_limits_are_told_at_once(tmp_path: Path) -> None:
    (found,) = mistakes(tmp_path, OPEN.replace("bounds = { x = [-5, 5], y = [-5, 5] }\n", ""))
    assert "nothing limits x, y, so a planner cannot sample them." in found
    assert "Write x = [lower, upper], and the others likewise, below [bounds]." in found


def test_a_machine_without_inputs_is_not_searched_for() -> None:
    q = angle("q", speed=5.0)
    bob = Body("bob", rot_y(q) @ move(0, 0, -1), mass=1.0)
    scenario = {"system": System("pendulum", bodies=[bob]), "goal": {"q": 1.0}}
    with pytest.raises(InputError, match=r"it has no inputs, so that there is nothing to plan\. G"):
        kinolab.load(scenario)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.off", "OFF\n3 1 0\n0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n", "finite"),
        ("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n", "a.off"),
        ("a.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", "face"),
        ("a.stl", "nothing of the kind", "a.stl"),
        ("a.obj", "", "a.obj"),
    ],
)
def test_a_broken_mesh_is_refused_by_name(
    tmp_path: Path, name: str, content: str, words: str
) -> None:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / name).write_text(content)
    found = mistakes(tmp_path, OPEN + MESH.format(name))
    assert words in " ".join(found)


@pytest.mark.parametrize(
    ("size", "remedy"),
    [
        (20_000.0, "Write scale = 0.001 if the file is in millimetres, or change [world] bounds."),
        (0.02, "Write scale = 1000, or change [world] bounds."),
    ],
)
def test_a_mesh_in_another_unit_than_its_world_is_refused_with_the_likely_scale(
    size: float, remedy: str, tmp_path: Path
) -> None:
    (tmp_path / "meshes").mkdir()
    trimesh.creation.box((size, size, size)).export(tmp_path / "meshes" / "hall.stl")
    world = "\n[world]\nbounds = { x = [-10, 10], y = [-10, 10] }\n" + MESH.format("hall.stl")
    (mistake,) = mistakes(tmp_path, PENDULUM + world)
    assert remedy in mistake
    meant = problem_of(tmp_path, PENDULUM + world + f"scale = {20.0 / size}\n")
    assert np.ptp(meant.world.obstacles[0].vertices) == pytest.approx(20.0)


@pytest.mark.parametrize("path", ["../outside.off", "/etc/outside.off", "meshes/../../outside.off"])
def test_a_mesh_outside_the_folder_is_refused(tmp_path: Path, path: str) -> None:
    (tmp_path / "outside.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    text = OPEN + f'\n[[world.obstacle]]\nmesh = "{path}"\n'
    assert "below the scenario's folder" in " ".join(mistakes(tmp_path / "inside", text))


def test_a_mesh_outside_the_folder_is_refused_behind_a_link_too(tmp_path: Path) -> None:
    (tmp_path / "outside.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    (tmp_path / "inside" / "meshes").mkdir(parents=True)
    (tmp_path / "inside" / "meshes" / "link.off").symlink_to(tmp_path / "outside.off")
    found = mistakes(tmp_path / "inside", OPEN + MESH.format("link.off"))
    assert "lies outside" in " ".join(found)


# --- a user's own file ---


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("def make():\n    return 1 / 0\n", "ZeroDivisionError"),
        ("1 / 0\n", "ZeroDivisionError"),
        ("def make(:\n", "SyntaxError"),
        ("import nowhere_at_all\n", "nowhere_at_all"),
        ("def make():\n    return 3\n", "int"),
        ("def made():\n    return 3\n", "Did you mean 'made'"),
        ("make = 3\n", "make"),
        ("import sys\nsys.exit(0)\n", "SystemExit"),
        ("def make():\n    raise BaseException('odd')\n", "BaseException: odd"),
        ("import sys\ndef make():\n    sys.exit(0)\n", "SystemExit"),
        ("def make(needed):\n    return 3\n", "TypeError"),
    ],
)
def test_a_users_file_that_fails_is_the_users_mistake(
    tmp_path: Path, code: str, words: str
) -> None:
    (tmp_path / "own.py").write_text(code)
    text = OPEN.replace('name = "rolling_disk"', 'file = "own.py:make"')
    found = mistakes(tmp_path, text)
    assert words in " ".join(found)
    assert "[system] file" in " ".join(found)


@pytest.mark.parametrize(
    ("code", "told"),
    [
        (
            "\n\n1 / 0\n",
            "running own.py failed on line 3 (ZeroDivisionError: division by zero).",
        ),
        (
            "\ndef make():\n    return [].pop()\n",
            "running make() of own.py failed on line 3 (IndexError: pop from empty list).",
        ),
        (
            "\nimport nowhere\n",
            "running own.py failed on line 2 (ModuleNotFoundError: No module named 'nowhere').",
        ),
        (
            "\ndef make(:\n",
            "running own.py failed on line 2 (SyntaxError: invalid syntax (own.py, line 2)).",
        ),
        (
            "import json\ndef make():\n    return json.loads('{')\n",
            "running make() of own.py failed on line 3 (JSONDecodeError: Expecting property name "
            "enclosed in double quotes: line 1 column 2 (char 1)).",
        ),
    ],
)
def test_a_failure_is_told_by_the_line_of_the_users_file(
    tmp_path: Path, code: str, told: str
) -> None:
    """Not by the line of Python's own that gave up."""
    (tmp_path / "own.py").write_text(code)
    text = OPEN.replace('name = "rolling_disk"', 'file = "own.py:make"')
    assert mistakes(tmp_path, text) == [f"table.toml [system] file: {told}"]


MACHINE = """
from kinolab import systems
from kinolab.dynamics import System

def half(x): return x / 2
def _spare() -> System: return systems.get("crane")
def built() -> System: return systems.get("pendulum", m=half(4))
def told(): return "no machine"
"""


def test_the_only_function_that_makes_a_machine_need_not_be_named(tmp_path: Path) -> None:
    """Not by commands, by their path from anywhere, and not by a scenario."""
    file = tmp_path / "own.py"
    file.write_text(MACHINE)
    assert find_machine(str(file)).name == "pendulum"
    assert find_system(find_scenario(str(file))).name == "pendulum"
    assert find_system(find_scenario(f"{file}:built")).name == "pendulum"
    text = 'schema = 1\ntitle = "t"\nsystem.file = "own.py"\ngoal.theta = 1\n'
    assert problem_of(tmp_path, text).machine.name == "pendulum"


@pytest.mark.parametrize(
    ("added", "told"),
    [
        ("def other() -> System: return built()\n", "may make the machine: built, other."),
        ("del built, told\n", "no function of own.py makes a machine."),
    ],
)
def test_a_machine_that_several_functions_or_none_may_make_is_refused(
    tmp_path: Path, added: str, told: str
) -> None:
    file = tmp_path / "own.py"
    file.write_text(MACHINE + added)
    for find in (find_machine, find_scenario):
        with pytest.raises(InputError, match=re.escape(told)):
            find(str(file))


def test_the_function_named_like_the_file_is_meant_among_several(tmp_path: Path) -> None:
    file = tmp_path / "built.py"
    file.write_text(MACHINE + "def other() -> System: return systems.get('crane')\n")
    assert find_machine(str(file)).name == "pendulum"


@pytest.mark.parametrize("what", ["own.py", "own.py:built"])
def test_code_where_a_scenario_is_meant_is_told_what_it_is(what: str) -> None:
    with pytest.raises(InputError, match=r"this is Python code, not a scenario\."):
        kinolab.load(what)


def test_two_files_of_one_name_do_not_shadow_each_other(tmp_path: Path) -> None:
    for name in ("rolling_disk", "pendulum"):
        (tmp_path / name).mkdir()
        code = f"from kinolab.systems import get\ndef make():\n    return get({name!r})\n"
        (tmp_path / name / "own.py").write_text(code)
    found = [
        find_machine(f"{tmp_path}/{name}/own.py:make") for name in ("rolling_disk", "pendulum")
    ]
    assert [system.name for system in found] == ["rolling_disk", "pendulum"]


@pytest.mark.parametrize(
    "content",
    [b"", b"\xff\xfe", b"[]", b"null", b"{}", b'{"format": "kinolab machine", "version": 1}'],
)
def test_a_damaged_machine_file_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "machine.json").write_bytes(content)
    text = OPEN.replace('name = "rolling_disk"', 'file = "machine.json"')
    assert "machine" in " ".join(mistakes(tmp_path, text))


@pytest.mark.parametrize(
    "ending",
    [
        *(".json", ".py"),
        pytest.param(".urdf", marks=needs("yourdfpy")),
        pytest.param(".xml", marks=needs("mujoco")),
    ],
)
def test_a_machine_whose_name_no_system_takes_is_not_there(tmp_path: Path, ending: str) -> None:
    text = PENDULUM.replace('name = "pendulum"', f'file = "{300 * "a"}{ending}"')
    told = mistakes(tmp_path, text)
    assert any("there is no" in one and "file" in one for one in told), told


def test_an_unknown_system_or_scenario_is_told_with_those_that_exist() -> None:
    with pytest.raises(InputError, match="Did you mean 'pendulum'"):
        find_machine("pendulums")


def test_a_problem_says_the_names_it_was_loaded_from(table: PlanningTask) -> None:
    assert (table.name, table.system.name) == ("table", "rolling_disk")


# --- another planner than the file's ---


def test_another_planner_has_settings_of_its_own(tmp_path: Path) -> None:
    text = OPEN.replace('name = "rrt"', 'name = "rrt"\nmax_steps = 7\ngoal_bias = 0.3')
    other = problem_of(tmp_path, text, "planner.name=est").scenario.planner
    assert other.settings == {}
    same = problem_of(tmp_path, text, "planner.name=rrt").scenario.planner
    assert same.settings == {"max_steps": 7, "goal_bias": 0.3}
    typed = problem_of(tmp_path, text, "planner.name=est", "planner.max_steps=9").scenario.planner
    assert typed.settings == {"max_steps": 9}
    unnamed = OPEN.replace('name = "rrt"', "max_steps = 7")
    assert problem_of(tmp_path, unnamed, "planner.name=auto").scenario.planner.settings == {
        "max_steps": 7
    }
    assert problem_of(tmp_path, unnamed, "planner.name=est").scenario.planner.settings == {}


def test_what_is_typed_beside_another_planner_must_fit_it(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no setting of est is called 'intermediate_states'"):
        problem_of(tmp_path, OPEN, "planner.name=est", "planner.intermediate_states=true")


@pytest.mark.parametrize(
    ("name", "value"), [("m", "1e300"), ("m", "1e-300"), ("R", "1e-300"), ("g", "-1e200")]
)
def test_a_parameter_whose_products_overflow_is_refused(
    name: str, value: str, tmp_path: Path
) -> None:
    """m R^2 w^2 with numbers beyond 1e60 is no double any more, or 0."""
    path = tmp_path / "disk.toml"
    path.write_text(
        'schema = 1\ntitle = "t"\n[system]\nname = "rolling_disk"\n'
        f"parameters = {{ {name} = {value} }}\n"
        "[world]\nbounds = { x = [0, 10], y = [0, 10] }\n[goal]\nx = 9.0\ntolerance = 0.1\n"
    )
    with pytest.raises(InputError, match=rf"parameters.{name}: {name} = .* than can be computed"):
        kinolab.load(path)
