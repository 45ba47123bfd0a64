"""Scenario files: what they may say, and what is answered when they say something else."""

from __future__ import annotations

import json
import math
import os
import re
import string
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from kinolab.errors import InputError, Mistake
from kinolab.scenario import (
    ObstacleEntry,
    Origin,
    Scenario,
    SystemSection,
    WorldSection,
    axis_vector,
    builtin_scenarios,
    check_names,
    improvement_seconds,
    load_scenario,
    write_scenario,
)
from tests.support import within

patient = settings(deadline=None)  # files are written and read; a busy disk is no failure

HEAD = 'schema = 1\ntitle = "A crane"\n[system]\nname = "crane"\n'
BOX = "[[world.obstacle]]\nbox = [1, 1, 1]\n"


def load(body: str, *overrides: str, head: str = HEAD) -> Scenario:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "crane.toml"
        file.write_text(head + body, encoding="utf-8")
        return load_scenario(file, overrides=overrides)


def mistakes(body: str, *overrides: str, head: str = HEAD) -> list[str]:
    with pytest.raises(InputError) as caught:
        load(body, *overrides, head=head)
    return [str(mistake) for mistake in caught.value.mistakes]


# --- what is right ---


def test_a_scenario_needs_a_schema_a_title_and_a_system() -> None:
    scenario = load("")
    assert scenario.schema_version == 1
    assert scenario.title == "A crane"
    assert scenario.system.name == "crane"


def test_defaults_are_those_that_the_documentation_promises() -> None:
    scenario = load(BOX + '[[goal.point]]\nbody = "hook"\nposition = [1, 2, 3]\n')
    assert (scenario.world.ground, scenario.world.bounds) == ("none", {})
    assert scenario.world.obstacle[0].position == scenario.world.obstacle[0].rpy == (0, 0, 0)
    assert (scenario.goal.tolerance, scenario.goal.at_rest) == (0.1, False)
    assert (scenario.goal.point[0].at, scenario.goal.point[0].tolerance) == ((0, 0, 0), 0.1)
    integration, planner, render = scenario.integration, scenario.planner, scenario.render
    assert (integration.method, integration.step, integration.truth) == ("rk4", 0.05, "continuous")
    assert (planner.name, planner.time_limit, planner.seed) == ("auto", 30.0, 1)
    assert (planner.max_iterations, planner.improve) == (None, "auto")
    assert improvement_seconds(planner.improve) == 2.0
    assert (render.view, render.speed, render.size) == ("perspective", 1.0, (800, 600))


def test_free_keys_of_goal_and_planner_are_set_apart() -> None:
    scenario = load("[goal]\nx = 1\nR = [0, 0, 0, 1]\ntolerance = 0.5\n[planner]\nbias = 0.2\n")
    assert scenario.goal.values == {"x": 1.0, "R": (0.0, 0.0, 0.0, 1.0)}
    assert scenario.goal.tolerance == 0.5
    assert scenario.planner.settings == {"bias": 0.2}


@pytest.mark.parametrize("name", ["values", "copy", "model_config", "free", "a b", "θ", ""])
def test_a_coordinate_may_have_any_name(name: str) -> None:
    scenario = load(f'[start]\n"{name}" = 2\n[goal]\n"{name}" = 3\n')
    assert scenario.start == {name: 2.0}
    assert scenario.goal.values == {name: 3.0}


def test_whole_numbers_may_stand_where_numbers_are_meant() -> None:
    step = load("[integration]\nstep = 1\n").integration.step
    assert isinstance(step, float)
    assert step == 1.0


def test_tolerance_may_be_a_table_and_what_it_leaves_out_has_the_default() -> None:
    goal = load("[goal]\ntolerance = { x = 0.2, x_dot = 1 }\n").goal
    assert goal.tolerance == {"x": 0.2, "x_dot": 1.0}
    assert (goal.tolerance_of("x"), goal.tolerance_of("y")) == (0.2, 0.1)
    assert load("[goal]\ntolerance = 0.3\n").goal.tolerance_of("x") == 0.3


def test_nameless_obstacles_are_called_after_their_kind_and_count_or_their_mesh() -> None:
    mesh = '[[world.obstacle]]\nmesh = "meshes/maze.stl"\n'
    named = '[[world.obstacle]]\nsphere = 1\nname = "box 1"\n'
    names = [entry.name for entry in load(BOX + mesh + mesh + BOX + named).world.obstacle]
    assert names == ["box 2", "maze", "maze 3", "box 4", "box 1"]


@pytest.mark.parametrize(
    ("axis", "vector"),
    [
        ("x", (1, 0, 0)),
        ("-z", (0, 0, -1)),
        ((0.0, 3.0, 4.0), (0, 0.6, 0.8)),
        ((1e308, 1e308, 0.0), (math.sqrt(0.5), math.sqrt(0.5), 0)),
    ],
)
def test_axes_are_unit_vectors(axis: Any, vector: tuple[float, ...]) -> None:
    assert axis_vector(axis) == pytest.approx(vector, abs=1e-15)  # rounding of one division


def test_a_scenario_cannot_be_changed() -> None:
    with pytest.raises(ValidationError):
        load("").title = "other"


def test_a_scenario_knows_its_folder_and_name(tmp_path: Path) -> None:
    file = tmp_path / "crane.toml"
    file.write_text(HEAD)
    scenario = load_scenario(file)
    assert (scenario.folder, scenario.name) == (tmp_path, "crane")
    elsewhere = scenario.located(Origin(Path("runs/other.toml")))
    assert (elsewhere.folder, elsewhere.name) == (Path("runs"), "other")
    assert elsewhere == scenario


@pytest.mark.parametrize("file", ["..toml", "...toml"])
def test_a_scenario_is_not_called_as_a_folder_above_its_runs(file: str, tmp_path: Path) -> None:
    (tmp_path / file).write_text(HEAD)
    assert load_scenario(tmp_path / file).name == file


def test_a_byte_order_mark_and_windows_line_ends_are_welcome(tmp_path: Path) -> None:
    file = tmp_path / "crane.toml"
    file.write_bytes(b"\xef\xbb\xbf" + HEAD.replace("\n", "\r\n").encode())
    assert load_scenario(file).title == "A crane"


# --- what is wrong in a key ---


def test_a_scenario_with_four_mistakes_reports_all_four() -> None:
    body = (
        "[world]\n[[world.obstacle]]\nsphere = 1\n[[world.obstacle]]\n"
        'mesh = "../maze.stl"\n[start]\nx = nan\n[planner]\ntime_limit = "5"\n'
        '[integration]\nmetod = "rk4"\n'
    )
    assert mistakes(body) == [
        'crane.toml [[world.obstacle]] 2 mesh: "../maze.stl" does not lead to a file below the '
        'scenario\'s folder. Give a relative path such as "meshes/maze.stl" (.dae, .glb, .obj, '
        ".off, .ply, .stl).",
        "crane.toml [start] x: nan is not finite. "
        'Give a number, an angle such as "pi/2" or "90 deg", or four numbers x, y, z, w for a '
        "rotation.",
        'crane.toml [planner] time_limit: "5" is text, not a number. '
        "Give a positive number [s] (default 30.0).",
        "crane.toml [integration] metod: no key is called 'metod'. "
        "Did you mean 'method'? Known: method, step, substeps, tableau, truth.",
    ]


@pytest.mark.parametrize(
    ("body", "answer"),
    [
        ("[planner]\ntime_limit = true\n", "[planner] time_limit: true is not a number."),
        ("[planner]\ntime_limit = 0\n", "[planner] time_limit: 0 is too small."),
        ("[planner]\ntime_limit = inf\n", "[planner] time_limit: inf is not finite."),
        ("[planner]\nseed = 1.0\n", "[planner] seed: 1.0 is not a whole number."),
        ("[planner]\nseed = false\n", "[planner] seed: false is not a whole number."),
        ("[planner]\nseed = -1\n", "[planner] seed: -1 is too small."),
        ("[planner]\nseed = 9223372036854775808\n", "seed: 9223372036854775808 is too large."),
        ("[planner]\nmax_iterations = 0\n", "[planner] max_iterations: 0 is too small."),
        ("[planner]\nname = 3\n", "[planner] name: 3 is not text in quotes."),
        ("[planner]\nbias = nan\n", "[planner] bias: nan is not finite."),
        ("[planner]\nbias = 1979-05-27\n", "bias: 1979-05-27 is not something a planner can use."),
        ("[planner]\nseeed = [nan]\n", "seeed: [nan] holds a number that is not finite."),
        ('[start]\nx = "1"\n', '[start] x: "1" is text, not a number.'),
        ("[start]\nx = true\n", "[start] x: true is not a number."),
        ("[start]\nR = [0, 0, 1]\n", "[start] R: [0, 0, 1] is too short."),
        ("[start]\nR = [0, 0, 0, 0]\n", "[start] R: [0, 0, 0, 0] is zero and has no direction."),
        ("[start]\nR = [0, 0, 0, nan]\n", "[start] R: entry 4, nan, is not finite."),
        ("[bounds]\nx = [1, 1]\n", "x: [1, 1] does not have its low end below its high end."),
        ("[bounds]\nx = [0, inf]\n", "[bounds] x: entry 2, inf, is not finite."),
        ("[metric]\nx = -1\n", "[metric] x: -1 is too small."),
        ("[world.bounds]\nw = [0, 1]\n", "[world] bounds.w: no axis is called 'w'."),
        ("[world.bounds]\nx = [1, 0]\n", "bounds.x: [1, 0] does not have its low end below"),
        ('[world]\nground = "plain"\n', '"plain" is none of the choices. Did you mean "plane"?'),
        (
            BOX + "scale = 2\n",
            "[[world.obstacle]] 1 scale: scale is a key of meshes and clouds only.",
        ),
        (BOX + "solid = false\n", "[[world.obstacle]] 1 solid: solid is a key of meshes only."),
        (BOX + "sphere = 1\n", "1 sphere: box and sphere are given together."),
        (
            "[[world.obstacle]]\nname = 'a'\n",
            "1: none of mesh, box, sphere, cylinder, capsule, map, cloud and run is",
        ),
        (BOX + BOX.replace("1, 1,", "1, 'a',"), '[[world.obstacle]] 2 box: entry 2, "a", is text'),
        (BOX + "position = [1, 2]\n", "[[world.obstacle]] 1 position: [1, 2] is too short."),
        ("[[world.obstacle]]\nmesh = 'a.zip'\n", '"a.zip" is not a mesh format that kinolab reads'),
        ("[[world.obstacle]]\nmesh = '/a.stl'\n", '"/a.stl" does not lead to a file below'),
        ("[[world.obstacle]]\nmesh = 'C:\\a.stl'\n", "does not lead to a file below"),
        (
            (BOX + "name = 'a'\n") * 2,
            '[[world.obstacle]] 2 name: obstacle 1 is called "a" too. '
            "Give every obstacle a name of its own.",
        ),
        ("[goal]\ntolerance = { x = 0 }\n", "[goal] tolerance.x: 0 is too small."),
        ("[goal]\nat_rst = true\n", "at_rst: true is not a number. Did you mean 'at_rest'?"),
        ("[[goal.point]]\nposition = [1, 2, 3]\n", "[[goal.point]] 1 body: the key is missing."),
        (
            "[[goal.direction]]\nbody = 'a'\naxis = 'w'\ntarget = [0, 0, 1]\n",
            '[[goal.direction]] 1 axis: "w" is none of the choices.',
        ),
        (
            "[[keep_out]]\nbody = 'a'\naxis = 'x'\ndirection = [1, 0, 0]\nhalf_angle = 4\n",
            "[[keep_out]] 1 half_angle: 4 is too large. Give a positive number of at most "
            "3.14159 [rad].",
        ),
        ('[integration]\nmethod = "rk5"\n', '"rk5" is none of the choices. Did you mean "rk4"?'),
        ("[render]\nsize = [800, 10]\n", "[render] size: entry 2, 10, is too small."),
        ("[render]\nsize = [800.0, 600]\n", "size: entry 1, 800.0, is not a whole number."),
        ("[plannr]\nseed = 1\n", "plannr: no section is called 'plannr'. Did you mean 'planner'?"),
        ("[planner]\ntime_limt = 1\n", "time_limt'. Did you mean 'time_limit'?"),
        ("[start.x]\ny = 1\n", "[start] x: { y = 1 } is not a number."),
        ("[[start]]\nx = 1\n", "[start]: [{ x = 1 }] is not a table. Write [start] on a line"),
    ],
)
def test_a_mistake_says_where_and_what(body: str, answer: str) -> None:
    found = mistakes(body)
    assert len(found) == 1
    assert answer in found[0]


@pytest.mark.parametrize(
    ("head", "answer"),
    [
        (HEAD.replace("1", "2"), "schema: 2 is none of the choices. Give schema = 1; a newer"),
        (HEAD.replace("1", "true"), "schema: true is not a whole number."),
        (HEAD.replace("1", "1.0"), "schema: 1.0 is not a whole number."),
        (HEAD.replace("A crane", ""), 'title: "" is empty.'),
        (HEAD + 'file = "m.py:f"\n', "[system] file: name and file are given together."),
        (HEAD.replace("name =", "file ="), '"crane" does not name a machine in a file.'),
        (HEAD.replace('name = "crane"', ""), "[system]: none of name and file is given."),
        (HEAD.replace('name = "crane"', 'file = "a\\\\m.py"'), "neither absolute nor relative to"),
        (HEAD + 'parameters = { R = "1" }', '[system] parameters.R: "1" is text, not a number.'),
        ('schema = 1\ntitle = "t"\n', "[system]: the section is missing. Write [system] on a line"),
        ('schema = 1\n[system]\nname = "a"\n', "title: the key is missing."),
    ],
)
def test_a_mistake_in_the_head_says_where_and_what(head: str, answer: str) -> None:
    found = mistakes("", head=head)
    assert len(found) == 1
    assert found[0].startswith("crane.toml ")
    assert answer in found[0]


@pytest.mark.parametrize(
    "file", ["machine.py:crane", "sub/machine.py:f", "m.py", "assets/machine.json"]
)
def test_a_machine_may_come_from_code_or_from_data(file: str) -> None:
    assert load("", head=HEAD.replace('name = "crane"', f'file = "{file}"')).system.file == file


def test_rules_that_join_keys_speak_up_beside_other_mistakes() -> None:
    found = mistakes("[[world.obstacle]]\nbox = [1, 1]\nsphere = 1\nup = 3\n")
    assert [text.split(":")[0] for text in found] == [
        "crane.toml [[world.obstacle]] 1 box",
        "crane.toml [[world.obstacle]] 1 sphere",
        "crane.toml [[world.obstacle]] 1 up",
        "crane.toml [[world.obstacle]] 1 up",
    ]


def test_the_same_rules_hold_in_python() -> None:
    with pytest.raises(ValidationError, match="box and sphere are given together"):
        ObstacleEntry(box=(1, 1, 1), sphere=1)
    with pytest.raises(ValidationError, match="none of name and file is given"):
        SystemSection()
    twins = tuple(ObstacleEntry(sphere=1, name="a") for _ in range(2))
    with pytest.raises(ValidationError, match="Give every obstacle a name of its own"):
        WorldSection(obstacle=twins)


def test_a_hopeless_file_is_answered_briefly() -> None:
    found = mistakes("[integration]\n" + "".join(f"key{i} = 1\n" for i in range(5000)))
    assert len(found) == 101
    assert found[-1] == "crane.toml: there may be more mistakes than these. Mend these first."


# --- files that are not scenarios ---


def refusal(source: str | Path) -> Mistake:
    with pytest.raises(InputError) as caught:
        load_scenario(source)
    (mistake,) = caught.value.mistakes
    return mistake


@pytest.mark.parametrize(
    ("content", "where", "what"),
    [
        (b"", "", "the file is empty."),
        (b"  \n", "", "the file is empty."),
        (b"# nothing\n", "", "the file holds no keys."),
        (b"\n\xff = 1", " line 2", "this is not UTF-8 text."),
        (
            b"schema = 1\ntime limit = 5\n",
            " line 2, column 6",
            "this is not TOML: expected '=' after a key in a key/value pair. "
            "The line reads 'time limit = 5'.",
        ),
        (b"a = [1,", " line 1", "this is not TOML: invalid value (at the end)."),
        (b"a = " + b"[" * 5000, "", "its lists or tables are nested too deep."),
        (b"a = " + b"9" * 5000, "", "one of its numbers is too long to read."),
    ],
)
def test_a_file_that_is_not_toml_is_refused(
    tmp_path: Path, content: bytes, where: str, what: str
) -> None:
    file = tmp_path / "crane.toml"
    file.write_bytes(content)
    mistake = refusal(file)
    assert (mistake.where, mistake.what) == (f"crane.toml{where}", what)
    assert mistake.remedy


def test_a_file_of_thirty_megabytes_is_read_and_a_larger_one_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "crane.toml"
    file.write_text(HEAD + "#" * (30_000_000 - len(HEAD)))
    assert load_scenario(file).title == "A crane"
    file.write_text(HEAD + "#" * (30_000_001 - len(HEAD)))
    assert refusal(file).what == "it cannot be read: it is larger than 30 MB."


@pytest.mark.parametrize("name", ["crano.toml", "crane.tml"])
def test_a_missing_file_is_named_in_full_with_its_neighbour(tmp_path: Path, name: str) -> None:
    (tmp_path / "crane.toml").write_text(HEAD)
    mistake = refusal(tmp_path / name)
    assert mistake.what == f"there is no file {tmp_path / name}."
    assert mistake.remedy == "Did you mean 'crane.toml'?"


def test_a_folder_is_not_a_scenario(tmp_path: Path) -> None:
    (tmp_path / "crane.toml").write_text(HEAD)
    mistake = refusal(tmp_path)
    assert mistake.what == "this is a folder, not a scenario."
    assert mistake.remedy == "In it: crane.toml."


@pytest.mark.skipif(not Path(os.devnull).exists(), reason="has no device files")
def test_a_device_is_not_a_scenario() -> None:
    assert refusal(Path(os.devnull)).what == "this is not an ordinary file."


@pytest.mark.parametrize("source", ["", "x" * 5000, "a\0b", "a\0b.toml", "no/such/file", "~"])
def test_a_strange_path_is_an_input_error(source: str) -> None:
    assert refusal(source).what


def with_builtins(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    (folder / "meshes").mkdir()
    for name in ("crane.toml", "maze.toml", "__init__.py"):
        (folder / name).write_text(HEAD if name.endswith(".toml") else "")
    monkeypatch.setattr("importlib.resources.files", lambda _: folder)


def test_builtin_scenarios_go_by_name(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with_builtins(monkeypatch, tmp_path)
    assert builtin_scenarios() == {name: tmp_path / f"{name}.toml" for name in ("crane", "maze")}
    assert load_scenario("maze").name == "maze"
    mistake = refusal("creane")
    assert mistake.what.startswith("no scenario is called 'creane', and there is no file ")
    assert mistake.remedy == "Did you mean 'crane'? Built in: crane, maze."
    assert "there is no file" in refusal("creane.toml").what


def test_a_path_object_is_never_a_builtin(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with_builtins(monkeypatch, tmp_path)
    assert "no file" in refusal(Path("maze")).what


def test_a_library_without_its_scenarios_still_reads_files(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(package: str) -> Path:
        raise ModuleNotFoundError(package)

    monkeypatch.setattr("importlib.resources.files", missing)
    assert builtin_scenarios() == {}
    assert load("").title == "A crane"


# --- overrides ---


@pytest.mark.parametrize(
    ("override", "value"),
    [
        ("planner.time_limit=5", {"planner": {"time_limit": 5.0}}),
        ("planner.name=sst", {"planner": {"name": "sst"}}),
        ("planner.name = 'sst' # comment", {"planner": {"name": "sst"}}),
        ("title=Two words", {"title": "Two words"}),
        ("title='1'", {"title": "1"}),
        ("goal.at_rest=true", {"goal": {"at_rest": True}}),
        ('start."a=b.c"=7', {"start": {"a=b.c": 7.0}}),
        ("start.1=7", {"start": {"1": 7.0}}),
        ("goal.tolerance={ x = 1 }", {"goal": {"tolerance": {"x": 1.0}}}),
        ("goal.tolerance.x=1", {"goal": {"tolerance": {"x": 1.0}}}),
    ],
)
def test_an_override_sets_a_key(override: str, value: dict[str, Any]) -> None:
    written = load("", override).model_dump()
    for key, inner in value.items():
        found = written[key]
        assert ({k: found[k] for k in inner} if isinstance(inner, dict) else found) == inner


def test_overrides_count_entries_from_one_and_the_later_one_wins() -> None:
    overrides = [
        "world.obstacle.1.position=[0,0,1]",
        "world.obstacle.1.position=[0,0,2]",
        "world.obstacle.2.box.3=9",
    ]
    first, second = load(BOX + BOX, *overrides).world.obstacle
    assert first.position == (0.0, 0.0, 2.0)
    assert second.box == (1.0, 1.0, 9.0)


@pytest.mark.parametrize(
    ("override", "answer"),
    [
        ("planner.time_limt=5", "no key is called 'time_limt'. Did you mean 'time_limit'?"),
        ("planer.seed=5", "no section is called 'planer'. Did you mean 'planner'?"),
        ("integration.stp=5", "no key is called 'stp'. Did you mean 'step'?"),
        ("planner.time_limit=5s", '"5s" is text, not a number.'),
        ("planner.time_limit=nan", "nan is not finite."),
        ("system.file=m.py:f", "name and file are given together."),
        ("world.obstacle.1.sphere=1", "box and sphere are given together."),
        ("world.obstacle.2.sphere=1", "world.obstacle has no entry 2; it has 1."),
        ("world.obstacle.0.sphere=1", "world.obstacle has no entry 0; it has 1."),
        ("world.obstacle.x.sphere=1", "world.obstacle has no entry x; it has 1."),
        ("world.obstacle.1.rpy.1=1", "world.obstacle.1.rpy has no entry 1; it has 0."),
        ("keep_out.1.body=a", "keep_out has no entry 1; it has 0."),
        ("title.x=1", 'title is "A crane" and has no keys.'),
        ("title=", "nothing follows '='."),
        ("title=[1,", "[1, is not a TOML value."),
        ("title", "there is no '=' in it."),
        ("=1", "what stands before '=' is not a dotted key."),
        ("# a=1", "what stands before '=' is not a dotted key."),
        ("[a] # b=1", "what stands before '=' is not a dotted key."),
        ("a..b=1", "what stands before '=' is not a dotted key."),
        ("a\nb=1", "what stands before '=' is not a dotted key."),
        ("start.x=1\n[goal]", "is text, not a number."),
    ],
)
def test_a_mistake_in_an_override_names_the_override(override: str, answer: str) -> None:
    (found,) = mistakes(BOX, override)
    assert found.startswith(f"--set {override}: ")
    assert answer in found


def test_an_override_that_mends_a_mistake_leaves_none() -> None:
    assert load('[planner]\ntime_limit = "5"\n', "planner.time_limit=5").planner.time_limit == 5.0


def test_mistakes_of_file_and_overrides_come_together() -> None:
    found = mistakes("[planner]\nseed = -1\n", "planner.improve=-2", "nonsense")
    assert [text.split(":")[0] for text in found] == [
        "--set nonsense",
        "crane.toml [planner] seed",
        "--set planner.improve=-2",
    ]


def test_an_override_that_is_not_unicode_is_refused() -> None:
    (found,) = mistakes("", "title=\udc80")
    assert found == "--set title=\\udc80: the text is not Unicode. Write it in UTF-8."


# --- names ---


def unknown(scenario: Scenario) -> list[str]:
    found = check_names(scenario, ["x", "theta"], ["x_dot", "theta_dot"], ["mass"], ["hook"])
    return [str(mistake) for mistake in found]


def test_names_that_the_machine_has_are_no_mistakes() -> None:
    body = (
        "parameters = { mass = 2 }\n[bounds]\nx_dot = [-1, 1]\n[metric]\ntheta = 1\n"
        "[start]\nx = 1\n[goal]\ntheta = 1\ntolerance = { theta = 1 }\n"
        "[[goal.point]]\nbody = 'hook'\nposition = [0, 0, 0]\n"
    )
    assert unknown(load(body)) == []


def test_every_unknown_name_is_reported_with_the_nearest() -> None:
    body = (
        "parameters = { mas = 2 }\n[bounds]\nxdot = [-1, 1]\n[metric]\nteta = 1\n"
        "[start]\nthet = 1\n[goal]\ntolerence = 1\ntolerance = { thetadot = 1 }\n"
        "[[goal.point]]\nbody = 'hok'\nposition = [0, 0, 0]\n"
        "[[goal.direction]]\nbody = 'hooks'\naxis = 'x'\ntarget = [1, 0, 0]\n"
        "[[keep_out]]\nbody = 'boom'\naxis = 'x'\ndirection = [1, 0, 0]\nhalf_angle = 1\n"
    )
    found = unknown(load(body))
    assert [text.split(" Known")[0] for text in found] == [
        "crane.toml [system] parameters.mas: no parameter is called 'mas'. Did you mean 'mass'?",
        "crane.toml [bounds] xdot: no coordinate, rate or input is called 'xdot'. "
        "Did you mean 'x_dot'?",
        "crane.toml [metric] teta: no coordinate or rate is called 'teta'. Did you mean 'theta'?",
        "crane.toml [start] thet: no coordinate or rate is called 'thet'. Did you mean 'theta'?",
        "crane.toml [goal] tolerence: no coordinate or rate is called 'tolerence'. "
        "Did you mean 'tolerance'?",
        "crane.toml [goal] tolerance.thetadot: no coordinate or rate is called 'thetadot'. "
        "Did you mean 'theta_dot'?",
        "crane.toml [[goal.point]] 1 body: no body is called 'hok'. Did you mean 'hook'?",
        "crane.toml [[goal.direction]] 1 body: no body is called 'hooks'. Did you mean 'hook'?",
        "crane.toml [[keep_out]] 1 body: no body is called 'boom'. Did you mean 'hook'?",
    ]


def test_an_unknown_name_from_an_override_names_the_override() -> None:
    (found,) = unknown(load("", "start.thet=1"))
    assert found.startswith("--set start.thet=1: no coordinate or rate is called 'thet'.")


# --- writing ---


def test_a_written_scenario_has_every_default() -> None:
    text = write_scenario(load(BOX + "[goal]\nx = 1\n[planner]\nweights = { x = 2 }\n"))
    assert text == (
        'schema = 1\ntitle = "A crane"\n\n[system]\nname = "crane"\nparameters = {}\n\n'
        '[world]\nbounds = {}\nground = "none"\nclearance = 0.0\n\n'
        "[[world.obstacle]]\nbox = [1.0, 1.0, 1.0]\nposition = [0.0, 0.0, 0.0]\n"
        'rpy = [0.0, 0.0, 0.0]\nname = "box 1"\n\n[bounds]\n\n[metric]\n\n[start]\n\n'
        '[goal]\nx = 1.0\ntolerance = 0.1\nnorm = "max"\nat_rest = false\nreserve = 0.0\n'
        'hold = 0.0\norder = "written"\n\n'
        '[integration]\nmethod = "rk4"\nstep = 0.05\nsubsteps = 1\ntruth = "continuous"\n\n'
        '[planner]\nweights = { x = 2 }\nname = "auto"\ntime_limit = 30.0\nseed = 1\n'
        'improve = "auto"\n\n[render]\nview = "perspective"\nfollow = false\n'
        'setting = "studio"\nspeed = 1.0\nsize = [800, 600]\n'
        "magnify = true\naxes = false\n"
    )


number = st.floats(allow_nan=False, allow_infinity=False)
positive = st.floats(min_value=0, exclude_min=True, allow_infinity=False)
tolerance = st.floats(min_value=1e-12, allow_infinity=False)
line = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=8)
plain = st.text(  # what a person is shown
    st.characters(exclude_categories=["Cs", "Cc", "Cf", "Zl", "Zp"]), min_size=1, max_size=8
)
name = st.one_of(st.text(string.ascii_lowercase, min_size=1, max_size=4), line)
vector = st.tuples(number, number, number)
direction = vector.filter(any)
axis = st.one_of(st.sampled_from(["x", "-y", "z"]), direction)
limits = st.tuples(number, number).filter(lambda pair: pair[0] < pair[1])
coordinate = st.one_of(number, st.tuples(number, number, number, number).filter(any))
angle = st.floats(min_value=0, exclude_min=True, max_value=math.pi)
setting = st.recursive(
    st.one_of(st.booleans(), st.integers(-(2**63) + 1, 2**63 - 1), number, line),
    lambda inner: st.one_of(
        st.lists(inner, max_size=2).map(tuple), st.dictionaries(name, inner, max_size=2)
    ),
    max_leaves=4,
)
pose = {"position": vector, "rpy": vector}
scale = st.one_of(positive, st.tuples(positive, positive, positive))
obstacle = st.one_of(
    st.fixed_dictionaries({"box": st.tuples(positive, positive, positive)}, optional=pose),
    st.fixed_dictionaries({"sphere": positive}, optional=pose),
    st.fixed_dictionaries({"cylinder": st.tuples(positive, positive)}, optional=pose),
    st.fixed_dictionaries(
        {"mesh": st.sampled_from(["a.stl", "meshes/ä b.OBJ"])},
        optional={**pose, "scale": scale, "up": st.sampled_from("xyz"), "solid": st.booleans()},
    ),
)
point = st.fixed_dictionaries(
    {"body": plain, "position": vector}, optional={"at": vector, "tolerance": tolerance}
)
direction_goal = st.fixed_dictionaries(
    {"body": plain, "axis": axis, "target": direction},
    optional={"tolerance": angle.filter(lambda value: value >= 1e-12)},
)
cone = st.fixed_dictionaries(
    {"body": plain, "axis": axis, "direction": direction, "half_angle": angle},
    optional={"clearance": angle},
)
goal = st.builds(
    lambda free, fixed: {**free, **fixed},
    st.dictionaries(name, coordinate, max_size=2),
    st.fixed_dictionaries(
        {},
        optional={
            "tolerance": st.one_of(tolerance, st.dictionaries(name, tolerance, max_size=2)),
            "norm": st.sampled_from(["max", "sum", "euclidean"]),
            "at_rest": st.booleans(),
            "point": st.lists(point, max_size=2),
            "direction": st.lists(direction_goal, max_size=2),
        },
    ),
)
planner = st.builds(
    lambda free, fixed: {**{f"own_{key}": value for key, value in free.items()}, **fixed},
    st.dictionaries(name, setting, max_size=2),
    st.fixed_dictionaries(
        {},
        optional={
            "name": name,
            "time_limit": positive,
            "max_iterations": st.integers(1, 2**63 - 1),
            "seed": st.integers(0, 2**63 - 1),
        },
    ),
)
world = st.fixed_dictionaries(
    {},
    optional={
        "bounds": st.dictionaries(st.sampled_from("xyz"), limits),
        "ground": st.sampled_from(["plane", "none"]),
        "obstacle": st.lists(obstacle, max_size=3),
    },
)
system = st.one_of(
    st.fixed_dictionaries(
        {"name": plain}, optional={"parameters": st.dictionaries(name, number, max_size=2)}
    ),
    st.fixed_dictionaries({"file": st.just("machine.py:crane")}),
)
scenarios = st.fixed_dictionaries(
    {"schema": st.just(1), "title": plain, "system": system},
    optional={
        "world": world,
        "bounds": st.dictionaries(name, limits, max_size=2),
        "metric": st.dictionaries(name, positive, max_size=2),
        "start": st.dictionaries(name, coordinate, max_size=2),
        "goal": goal,
        "keep_out": st.lists(cone, max_size=2),
        "planner": planner,
        "render": st.fixed_dictionaries({"size": st.just((64, 4096)), "speed": positive}),
    },
).map(Scenario.model_validate)


@patient
@given(scenarios)
def test_a_written_scenario_reads_as_an_equal_one(scenario: Scenario) -> None:
    text = write_scenario(scenario)
    again = load(text, head="")
    assert again == scenario
    assert write_scenario(again) == text


# --- nothing but InputError ---


def survives(content: bytes, overrides: Sequence[str] = ()) -> None:
    """Read what may be anything: a scenario comes out, or mistakes in plain words."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "crane.toml"
        file.write_bytes(content)
        try:
            load_scenario(file, overrides=overrides)
            return
        except InputError as error:
            refused = error
    assert refused.mistakes
    assert "Input should be" not in str(refused)
    assert "does not fit here" not in str(refused)  # every kind of error has words of its own


SCALARS = [
    "1", "-1", "0", "1.5", "nan", "-inf", "true", '"5"', '""', "'x'", "1979-05-27", "07:32:00",
    "[]", "{}", "[1, 2, 3]", "[0, 0, 0, 1]", "[1, 'a', nan]", "[[1]]", "{ x = 1 }",
    "{ x = [2, 1] }",
    "[{}]", "[{ body = 'a' }]", "[{ box = [1, 1, 1], name = 3 }]", "0x" + "f" * 20, "'a.stl'",
    "0x" + "f" * 5000, "'m.py:f'", "'<list>'", "{ '<table>' = { '<number>' = 1 } }",
]  # fmt: skip
KEYS = [
    "schema", "title", "system", "world", "bounds", "metric", "start", "goal", "keep_out",
    "planner", "integration", "render", "name", "file", "parameters", "obstacle", "mesh", "box",
    "scale", "up", "solid", "tolerance", "norm", "at_rest", "hold", "via", "point", "direction",
    "body", "axis",
    "seed", "size", "x", "1",
    "'<list>'", "'[key]'", '"\\u0000"', "schema_version", "values", "_origin", "''",
]  # fmt: skip
dotted = st.lists(st.sampled_from(KEYS), min_size=1, max_size=4).map(".".join)
assignment = st.builds("{} = {}".format, dotted, st.sampled_from(SCALARS))
header = st.one_of(st.builds("[{}]".format, dotted), st.builds("[[{}]]".format, dotted))


@patient
@given(st.lists(st.one_of(assignment, header), max_size=8), st.booleans())
def test_no_toml_document_escapes_as_anything_but_an_input_error(
    lines: list[str], headed: bool
) -> None:
    survives(((HEAD if headed else "") + "\n".join(lines)).encode())


@patient
@given(st.sampled_from([*KEYS[2:12], "world.obstacle"]), st.lists(assignment, max_size=4))
def test_no_section_escapes_as_anything_but_an_input_error(section: str, lines: list[str]) -> None:
    brackets = ("[[", "]]") if section in ("world.obstacle", "keep_out") else ("[", "]")
    document = 'schema = 1\ntitle = "t"\nsystem.name = "a"\n'
    survives((document + section.join(brackets) + "\n" + "\n".join(lines)).encode())


@patient
@given(st.one_of(st.binary(max_size=40), st.text(max_size=40).map(lambda text: text.encode())))
def test_no_bytes_escape_as_anything_but_an_input_error(content: bytes) -> None:
    survives(content)


@patient
@given(
    st.lists(
        st.one_of(
            st.text(st.characters(), max_size=20),
            st.builds("{}={}".format, dotted, st.sampled_from(SCALARS)),
        ),
        max_size=3,
    )
)
@example(["schema=0x" + "f" * 20])
def test_no_override_escapes_as_anything_but_an_input_error(overrides: list[str]) -> None:
    survives((HEAD + BOX).encode(), overrides)


def test_endless_nesting_is_an_input_error() -> None:
    deep = ".".join("a" * 30)
    found = mistakes(f"[planner]\n{deep} = 1\n[start]\n{deep} = 1\n")
    assert re.fullmatch(r"crane.toml \[planner\] a: .* is nested more than 8 deep\..*", found[0])
    assert re.fullmatch(r"crane.toml \[start\] a: .* is not a number\..*", found[1])


@pytest.mark.parametrize("key", ["<list>", "<table>", "[key]"])
def test_a_key_that_looks_like_a_note_of_the_validator_is_a_key(key: str) -> None:
    tables = f'[world.bounds]\n"{key}" = 1\n[goal.tolerance]\n"{key}" = 0\n[start]\n"{key}" = "a"\n'
    found = mistakes(tables, head=f'"{key}" = 1\n{HEAD}')
    assert [text.split(":")[0] for text in found] == [
        f'crane.toml "{key}"',
        f'crane.toml [world] bounds."{key}"',
        f'crane.toml [world] bounds."{key}"',
        f'crane.toml [goal] tolerance."{key}"',
        f'crane.toml [start] "{key}"',
    ]


# --- files that would take all memory ---

DEEP = {
    "a key": "a" + ".a" * 490_000 + " = 1",
    "a table": "[" + "a." * 490_000 + "a]",
    "quoted parts": '"a"' + ' . "b"' * 100 + " = 1",
    "in a table": "x = { " + "a." * 100 + "a = 1 }",
}


@pytest.mark.parametrize("text", DEEP.values(), ids=DEEP)
def test_a_key_of_very_many_parts_is_refused_before_it_is_read(text: str, tmp_path: Path) -> None:
    """One of 1 MB took tomllib 8 GB, and minutes."""
    path = tmp_path / "deep.toml"
    path.write_text(f"schema = 1\n{text}\n")
    with within(20), pytest.raises(InputError, match=r"deep.toml line 2: a key has more than 32"):
        load_scenario(path)


@pytest.mark.parametrize("title", ["." * 900_000, "a. " * 300_000, "x" * 900_000, "'\\" * 300_000])
def test_dots_and_words_in_a_text_are_no_key(title: str, tmp_path: Path) -> None:
    path = tmp_path / "long.toml"
    path.write_text(f'schema = 1\ntitle = {json.dumps(title)}\n[system]\nname = "pendulum"\n')
    with within(20):
        assert load_scenario(path).title == title
