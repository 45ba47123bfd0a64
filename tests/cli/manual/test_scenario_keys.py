"""docs/scenarios.md has every key of a scenario, and all that it shows can be loaded."""

from __future__ import annotations

import re
import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

import kinolab
from kinolab.cli.manual import machine_words
from kinolab.cli.manual.scenario_keys import FREE, SOURCE, meanings, path_of, schema_keys, told
from kinolab.cli.manual.sections import ManualSection, sections_of, source_of
from kinolab.scenario.issues import KeyPath
from kinolab.scenario.locations import has_keys, section_at
from kinolab.scenario.schema import Scenario, Section
from kinolab.scenario.toml_text import value_text
from tests.cli.manual.examples import examples_in
from tests.support import ROOT

SECTIONS = list(sections_of(source_of(SOURCE)))
(COMPLETE,) = examples_in(next(s for s in SECTIONS if s.title == "A complete scenario"), "toml")
BY_PATH = {path: s for s in SECTIONS if (path := path_of(s)) is not None}
EXAMPLES = [
    pytest.param(example, id=f"{section.title} {k + 1}")
    for section in BY_PATH.values()
    for k, example in enumerate(examples_in(section, "toml"))
]


def tables(path: KeyPath = ()) -> list[KeyPath]:
    """Return every table of the schema that has keys, from the top down; others have [goal]'s."""
    section = section_at(path)
    assert section is not None
    known = ("via", "any_of", "machines", *(("system", "goal") if path == ("machine",) else ()))
    keys = [key for key in field_names(section) if key not in known]
    below = [(*path, key) for key in keys if has_keys((*path, key))]
    named = [one for one in below if section_at(one) is not None]
    return [path, *(inner for one in named for inner in tables(one))]


def field_names(section: type[Section]) -> list[str]:
    return [field.alias or name for name, field in section.model_fields.items()]


def keys_in(example: str, path: KeyPath) -> set[str]:
    """Return the keys that an example gives in a section."""
    found: list[Any] = [tomllib.loads(example)]
    for key in path:
        found = [part[key] for part in found if key in part]
        found = [entry for part in found for entry in (part if isinstance(part, list) else [part])]
    return {key for part in found for key in part}


@pytest.mark.parametrize("path", tables(), ids=lambda path: ".".join(path) or "top")
def test_every_key_has_a_meaning_and_an_example(path: KeyPath) -> None:
    """If this fails for a new key: tell it in manual/scenarios.md."""
    section = section_at(path)
    assert section is not None
    page, keys = BY_PATH[path], schema_keys(path)
    if section is not Scenario:
        assert set(keys) == set(field_names(section))
    assert set(meanings(page)) - {FREE} == set(keys)
    shown = set().union(*(keys_in(example, path) for example in examples_in(page, "toml")))
    assert set(keys) <= shown
    assert (FREE in meanings(page)) == (section.free is not None)
    assert not section.free or shown - set(keys)


@pytest.mark.parametrize("key", ["bounds", "metric", "start"])
def test_sections_of_names_alone_are_told_too(key: str) -> None:
    (page,) = (s for s in SECTIONS if s.title == f"[{key}]")
    assert set(meanings(page)) == {FREE}
    assert any(keys_in(example, (key,)) for example in examples_in(page, "toml"))


def test_every_section_of_a_scenario_is_on_the_page() -> None:
    named = {(key,) for key in ("bounds", "metric", "start", "via")} | {("goal", "any_of")}
    wanted = {path for path in tables() if path} | named
    assert set(BY_PATH) == wanted | {()}


@pytest.mark.parametrize("path", tables(), ids=lambda path: ".".join(path) or "top")
def test_the_defaults_are_those_that_a_scenario_gets(path: KeyPath) -> None:
    section, rows = section_at(path), told(BY_PATH[path]).text.splitlines()
    assert section is not None
    for name, field in section.model_fields.items():
        (row,) = [r for r in rows if r.startswith(f"| `{field.alias or name}` |")] or [""]
        default = row.split(" | ")[2:3]
        if field.is_required() and row:
            assert default == ["required"]
        elif isinstance(field.default, bool | int | float | str) and field.default != "":
            assert default == [f"`{value_text(field.default)}`"]


LINK = """<link name="{0}"><inertial><origin xyz="0 0 0.5"/><mass value="1"/>
<inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="{1}" type="revolute"><parent link="{2}"/><child link="{0}"/><axis xyz="0 1 0"/>
<origin xyz="0 0 1"/><limit lower="-2" upper="2" effort="40" velocity="3"/></joint>"""
ARM = (
    '<robot name="arm"><link name="base"/>'
    f"{LINK.format('upper', 'shoulder', 'base')}{LINK.format('lower', 'wrist', 'upper')}</robot>"
)


MODEL = """<mujoco><worldbody><body><joint name="shoulder" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.03" mass="1"/></body></worldbody><actuator>
<position joint="shoulder" kp="9" ctrlrange="-2 2" forcerange="-5 5"/></actuator></mujoco>"""


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """A folder with the files that the examples name."""
    (tmp_path / "meshes").mkdir()
    shutil.copy(ROOT / "scenarios/meshes/rolling_disk_maze.stl", tmp_path / "meshes/maze.stl")
    text = source_of(machine_words.SOURCE)
    whole = next(s for s in sections_of(text) if s.title == "A complete machine")
    (tmp_path / "cart_pendulum.py").write_text(examples_in(whole, "python")[0])
    (tmp_path / "arm.urdf").write_text(ARM)
    (tmp_path / "arm.xml").write_text(MODEL)
    _write_sensed(tmp_path)
    (tmp_path / "cart.csv").write_text("t,x,y,z\n0,5,3,0.25\n10,5,1,0.25\n")
    _write_run(tmp_path / "runs/truck")
    return tmp_path


def _write_run(folder: Path) -> None:
    """Write what is read of another plan: its scenario, and its motion."""
    folder.mkdir(parents=True)
    scenario = folder / "scenario.toml"
    scenario.write_text(
        'schema = 1\ntitle = "A truck"\n[system]\nname = "unicycle1_v0"\n'
        "[world]\nbounds = { x = [0, 6], y = [0, 4] }\n[bounds]\ntheta = [-3, 3]\n"
        "[start]\nx = 5.5\ny = 3.5\n[goal]\nx = 5.0\n"
    )
    kinolab.simulate(scenario, lambda _, __: [-0.1, 0.0], duration=2.0).to_csv(
        folder / "trajectory.csv"
    )


def _write_sensed(home: Path) -> None:
    """Write the map, the heights and the cloud that the examples name."""
    (home / "maps").mkdir()
    (home / "scans").mkdir()
    for name, level in {"office.pgm": 0, "hills.png": 255}.items():
        picture = Image.new("L", (20, 20), 255 - level)
        picture.putpixel((5, 5), level)
        picture.save(home / "maps" / name)
    lines = "image: office.pgm\nresolution: 0.05\norigin: [10.0, 10.0, 0.0]\n"
    (home / "maps/office.yaml").write_text(lines)
    axes = "".join(f"property float {axis}\n" for axis in "xyz")
    head = f"ply\nformat ascii 1.0\nelement vertex 2\n{axes}end_header\n"
    (home / "scans/hall.ply").write_text(f"{head}15000 9000 500\n9000 15000 500\n")


def completed(example: str) -> str:
    """Put a piece in the place of the complete scenario's own sections, as the page says."""
    own, base = tomllib.loads(example), tomllib.loads(COMPLETE)
    if "title" in own:
        return COMPLETE
    other = "system" in own and own["system"].get("name") != base["system"]["name"]
    alone = "machine" in own or other
    whole = COMPLETE.partition("[system]")[0]
    blocks = [] if alone else re.split(r"\n(?=\[)", COMPLETE.partition("\n\n")[2])
    kept = [b for b in blocks if re.split(r"[\].]", b.strip("["))[0] not in own]
    return "\n".join([whole, *kept, example])


@pytest.mark.parametrize("example", EXAMPLES)
def test_examples_can_be_loaded(example: str, home: Path) -> None:
    (home / "example.toml").write_text(completed(example))
    problem = kinolab.load(home / "example.toml")
    given = tomllib.loads(example)
    assert problem.scenario.title == tomllib.loads(COMPLETE)["title"]
    goal = given.get("goal", {})
    for name, value in (goal[-1] if isinstance(goal, list) else goal).items():
        if isinstance(value, bool | float):
            assert dict(problem.scenario.goal)[name] == value


def test_the_complete_scenario_is_solved(home: Path) -> None:
    (home / "crate.toml").write_text(COMPLETE)
    found = kinolab.load(home / "crate.toml").solve(optimize=False)
    assert found.status == "solved"


def test_a_key_without_a_meaning_would_be_noticed() -> None:
    silent = ManualSection(3, "[render]", "- `view`: From where one looks.\n")
    assert set(meanings(silent)) != set(schema_keys(("render",)))
    assert "| `view` |" in told(silent).text
