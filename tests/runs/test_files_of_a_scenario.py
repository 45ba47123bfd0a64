"""A run has a copy of every file that its scenario names: it is checked where none of them is."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import get_args

import pytest
from pydantic import BaseModel

import kinolab
from kinolab.runs import check_run
from kinolab.scenario import Scenario
from kinolab.scenario.values import Wanted
from tests.search.plugins.authors import PLANNER
from tests.support import OPEN, problem_of

MACHINE = "from kinolab.systems import get\ndef coin():\n    return get('rolling_disk')\n"
TETRAHEDRON = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
MAP = "image: picture.pgm\nresolution: 0.5\norigin: [-5.0, 3.0, 0.0]\nnegate: 0\n"
BOX = "box = [0.2, 0.2, 0.2]\n"
OBSTACLE = "\n[[world.obstacle]]\n"
WAY = "t,x,y,z\n0,-4,-4,0.5\n4,4,-4,0.5\n"
NAMED: dict[str, tuple[dict[str, str], str]] = {  # files and what names them, by the key
    "mesh": ({"post.off": TETRAHEDRON}, f'{OBSTACLE}mesh = "post.off"\nposition = [3, 3, 0]\n'),
    "map": (
        {"hall.yaml": MAP, "picture.pgm": "P2 2 1 255\n0 255\n"},
        f'{OBSTACLE}map = "hall.yaml"\n',
    ),
    "cloud": ({"scan.xyz": "4 4 0.2\n4 3 0.2\n"}, f'{OBSTACLE}cloud = "scan.xyz"\nradius = 0.1\n'),
    "motion.file": ({"way.csv": WAY}, f'{OBSTACLE}{BOX}motion = {{ file = "way.csv" }}\n'),
    "run": ({}, f'{OBSTACLE}run = "earlier"\nname = "other"\n'),
    "system.file": ({"own.py": MACHINE}, 'file = "own.py:coin"'),
    "planner.name": ({"pusher.py": PLANNER}, 'name = "pusher.py:Pusher"'),
}
REPLACED = {"system.file": 'name = "rolling_disk"', "planner.name": 'name = "rrt"'}


def keys_of_files(kind: type[BaseModel], before: str = "") -> Iterator[str]:
    """Yield the keys of a section that name a file or a folder, by what they say they take."""
    for name, field in kind.model_fields.items():
        said = " ".join(m.phrase for m in field.metadata if isinstance(m, Wanted))
        said += str(field.annotation)
        if re.search(r"relative path|folder of|\.py:", said):
            yield f"{before}{name}"
        for inner in _sections(field.annotation):
            yield from keys_of_files(inner, f"{name}.") if name != "machines" else ()


def _sections(annotation: object) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in get_args(annotation):
        yield from _sections(argument)


def test_every_key_that_names_a_file_is_tried_here() -> None:
    keys = {key.removeprefix("obstacle.") for key in keys_of_files(Scenario)}
    assert keys == NAMED.keys()


@pytest.mark.parametrize("key", NAMED)
def test_a_run_is_checked_where_the_files_of_its_scenario_are_not(key: str, tmp_path: Path) -> None:
    files, text = NAMED[key]
    home = tmp_path / "home"
    home.mkdir()
    for name, content in files.items():
        (home / name).write_text(content)
    if key == "run":
        side = OPEN.replace("x = -1.0", "x = -1.0\ny = 3.0").replace("y = 0.0", "y = 3.0")
        problem_of(home, side, name="side.toml").solve(seed=1, improve=0).save(home / "earlier")
    old = REPLACED.get(key)
    scenario = OPEN.replace(old, text) if old else OPEN + text
    assert scenario != OPEN
    problem = problem_of(home, scenario)
    Path(problem.solve(seed=1, improve=0).save(home / "run")).rename(tmp_path / "mailed")
    shutil.rmtree(home)
    certificate = check_run(tmp_path / "mailed")
    assert certificate.passed
    again = kinolab.load(tmp_path / "mailed" / "scenario.toml")
    assert [o.name for o in again.world.obstacles] == [o.name for o in problem.world.obstacles]
    assert again.world.clearance == problem.world.clearance
    for copy in (tmp_path / "mailed" / "assets").iterdir():
        content = copy.read_bytes()
        copy.write_bytes(content + b"\n")
        assert not check_run(tmp_path / "mailed").passed, copy.name
        copy.write_bytes(content)
