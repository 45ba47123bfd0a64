"""Machines from the cache: without SymPy, and never those of before a change."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.dynamics.language.json.machine_file import FEEDBACK_FILE, machine_to_json
from kinolab.loading import find_machine
from tests.support import OPEN, problem_of

SERVER = """
import json, os, sys
import numba, numpy, pydantic  # what takes most time to import, and is no part of kinolab

for line in sys.stdin:
    given, place = json.loads(line)
    child = os.fork()
    if not child:
        import kinolab
        problem = kinolab.load(given[0], overrides=given[1:])
        described = "sympy" in sys.modules
        shapes, limits = problem.model.machine.bodies[0].shapes, problem.model.control_bounds
        with open(place, "w") as file:
            json.dump([described, " ".join(map(str, (*shapes, *limits.ravel())))], file)
        os._exit(0)
    os.waitpid(child, 0)
    print(flush=True)
"""
OWN = """
from kinolab.dynamics import Body, Force, Sphere, System, length, move
from sizes import RADIUS

def slider():
    x = length("x", -1, 1, speed=1)
    ball = Body("ball", move(x, 0, 0), mass=1.0, shape=Sphere(RADIUS))
    push = Force("push", on=ball, along=ball.frame.x, limit=1.0)
    return System("slider", bodies=[ball], inputs=[push])
"""
SLIDER = """
schema = 1
title = "A slider"
[system]
file = "slider.py:slider"
[goal]
x = 0.5
tolerance = 0.1
"""


Load = Callable[..., tuple[bool, str]]


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a copy of kinolab and a cache of its own."""
    home = tmp_path_factory.mktemp("home")
    package, ignored = Path(str(kinolab.__file__)).parent, shutil.ignore_patterns("*.nb?", "*.lock")
    shutil.copytree(package, home / "kinolab", ignore=ignored)
    home.joinpath("coin.toml").write_text(OPEN)
    return home


@pytest.fixture(scope="module")
def load(home: Path) -> Iterator[Load]:
    """Load a scenario in a process that has imported nothing of kinolab, nor SymPy.

    It is forked from one that waits for scenarios. Returned are whether a machine was described,
    and the facts.
    """
    folders = {"PYTHONPATH": str(home), "KINOLAB_CACHE": str(home / "cache")}
    server = subprocess.Popen(
        [sys.executable, "-c", SERVER],
        cwd=home,
        env={**os.environ, **folders, "NUMBA_CACHE_DIR": str(home / "loops")},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    place = home / "facts.json"

    def loaded(*given: str | Path) -> tuple[bool, str]:
        assert server.stdin
        assert server.stdout
        place.unlink(missing_ok=True)
        server.stdin.write(json.dumps([[*map(str, given)], str(place)]) + "\n")
        server.stdin.flush()
        assert server.stdout.readline(), "the process that forks others has ended"
        described, facts = json.loads(place.read_text(encoding="utf-8"))
        return described, facts

    with server:  # which ends with its stdin
        yield loaded


def edit(path: Path, before: str, after: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert before in text
    path.write_text(text.replace(before, after), encoding="utf-8")


def test_what_was_described_once_is_loaded_without_sympy_until_something_changes(
    home: Path, load: Load
) -> None:
    systems, numerics = home / "kinolab" / "systems", home / "kinolab" / "numerics"
    described, before = load("coin.toml")
    assert described
    assert load("coin.toml") == (False, before)

    wider = ("coin.toml", "system.parameters={ R = 0.2 }")
    described, facts = load(*wider)
    assert described
    assert "radius=0.2," in facts
    assert load(*wider) == (False, facts)

    edit(systems / "rolling_disk.py", "thickness=0.05", "thickness=0.06")
    described, facts = load("coin.toml")
    assert described
    assert "thickness=0.06" in facts
    assert load("coin.toml") == (False, facts)

    for changed in (systems / "_wheels.py", numerics / "riccati.py"):
        changed.write_text(changed.read_text(encoding="utf-8") + "\n# changed\n", encoding="utf-8")
        assert load("coin.toml") == (True, facts)
    edit(systems / "rolling_disk.py", "thickness=0.06", "thickness=0.05")


def test_a_limit_that_a_scenario_tightens_is_its_own(load: Load) -> None:
    tight = ("coin.toml", "bounds.drive=[-0.25, 0.5]")
    load(*tight)
    described, facts = load(*tight)
    assert not described
    assert "-0.25 0.5" in facts
    assert "-0.25 0.5" not in load("coin.toml")[1]


def test_a_users_python_file_is_run_every_time_with_all_that_it_imports(
    load: Load, tmp_path: Path
) -> None:
    tmp_path.joinpath("slider.py").write_text(
        f"import sys\nsys.path.insert(0, {str(tmp_path)!r})\n" + OWN
    )
    tmp_path.joinpath("slider.toml").write_text(SLIDER)
    for radius in ("0.25", "0.5"):
        tmp_path.joinpath("sizes.py").write_text(f"RADIUS = {radius}  # [m]\n")
        shutil.rmtree(tmp_path / "__pycache__", ignore_errors=True)
        described, facts = load(tmp_path / "slider.toml")
        assert described
        assert f"radius={radius}" in facts


def test_a_machine_in_a_json_file_is_known_by_its_text(load: Load, tmp_path: Path) -> None:
    text = OPEN.replace('name = "rolling_disk"', 'file = "coin.json"')
    tmp_path.joinpath("coin.toml").write_text(text)
    coin = tmp_path / "coin.json"
    coin.write_text(machine_to_json(find_machine("rolling_disk")))
    described, facts = load(tmp_path / "coin.toml")
    assert load(tmp_path / "coin.toml") == (False, facts)
    edit(coin, '"values": {}', '"values": {"R": 0.125}')
    described, facts = load(tmp_path / "coin.toml")
    assert described
    assert "radius=0.125" in facts
    coin.with_name(FEEDBACK_FILE).write_text("{}")  # no controller that could be read
    with pytest.raises(FileNotFoundError):  # of facts, since the process has failed
        load(tmp_path / "coin.toml")


def test_a_damaged_record_is_made_anew(home: Path, load: Load) -> None:
    _, facts = load("coin.toml")
    for record in (home / "cache").glob("*.described"):
        record.write_bytes(record.read_bytes()[:-1] + b"?")
    assert load("coin.toml") == (True, facts)
    assert load("coin.toml") == (False, facts)


def test_the_symbols_of_a_machine_from_the_cache_are_described_on_demand(tmp_path: Path) -> None:
    first, second = (problem_of(tmp_path, OPEN, "bounds.drive=[-0.5, 0.5]") for _ in range(2))
    assert machine_to_json(second.system) == machine_to_json(first.system)
    assert machine_to_json(second.model.system) == machine_to_json(first.model.system)
    assert second.model.system.inputs[0].limit == (-0.5, 0.5)
    x, u = np.linspace(-1, 1, 6), np.array([0.3, -0.2])
    np.testing.assert_array_equal(second.model.f(x, u), first.model.f(x, u))
