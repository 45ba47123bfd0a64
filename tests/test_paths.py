"""Commands take files of any name, and files of any bytes: a result, or a sentence."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO, TextIOWrapper
from itertools import product
from pathlib import Path

import pytest

import kinolab
from kinolab.cli import run as run_here
from kinolab.dynamics.language.json.machine_file import machine_to_json
from tests.support import ENTER, OPEN, environment

Sayer = Callable[..., tuple[int, str]]
NAME = os.fsdecode(b"n\xff")  # what Linux allows, and UTF-8 does not
PRINTED = "n\N{REPLACEMENT CHARACTER}"
OWN = 'from kinolab.systems import get\n\n\ndef own():\n    return get("pendulum")\n'
QUICK = ("--no-animation", "--set", "goal.tolerance=2", "--max-iterations", "2000")

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="others refuse such names")


@dataclass(frozen=True)
class Home:
    """A folder whose files have such names.

    Attributes:
        folder: The folder.
        said: What the command said as JSON that made the run in it.
    """

    folder: Path
    said: bytes


def run(home: Path, *arguments: str) -> bytes:
    """Run a command whose output takes nothing but UTF-8, in a process; return its stdout."""
    done = subprocess.run(
        [sys.executable, "-c", ENTER, *arguments],
        cwd=home, env=environment(PYTHONIOENCODING="utf-8:strict"),
        capture_output=True, timeout=300, check=False,
    )  # fmt: skip
    said = done.stdout.decode() + done.stderr.decode()
    assert "Traceback" not in said
    assert done.returncode == 0, said
    return done.stdout


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Home:
    """A folder with a scenario, a machine, Python code and a run whose names are no UTF-8."""
    home = tmp_path_factory.mktemp("paths")
    folder = home / NAME
    folder.mkdir()
    (home / f"{NAME}.toml").write_text(OPEN)
    (folder / "own.py").write_text(OWN)
    (folder / "machine.json").write_text(machine_to_json(kinolab.systems.get("pendulum")))
    said = run(home, f"{NAME}.toml", *QUICK, "--out", f"{NAME}/run", "--json")
    return Home(home, said)


def test_a_scenario_of_such_a_name_is_planned_and_checked(home: Home) -> None:
    run(home.folder, f"{NAME}.toml", *QUICK)
    folder = home.folder / "runs" / PRINTED
    assert json.loads((folder / "report.json").read_text("utf-8"))["scenario"] == PRINTED
    run(home.folder, "check", str(folder.relative_to(home.folder)))


def test_json_stays_json(home: Home) -> None:
    assert json.loads(home.said)["folder"] == f"{NAME}/run"


FINE = [
    ("check", f"{NAME}/run"),
    ("gallery", f"{NAME}/run"),
    ("view", f"{NAME}/run", "--no-browser"),
    ("view", f"{NAME}.toml", "--no-browser"),
    ("plot", f"{NAME}/run"),
    ("execute", f"{NAME}/run", "--runs", "2"),
    ("simulate", f"{NAME}/own.py:own", "--no-animation"),
    ("examine", f"{NAME}/own.py:own"),
    ("describe", f"{NAME}/own.py:own", "--json"),
    ("equations", f"{NAME}/own.py:own"),
    ("equations", f"{NAME}/machine.json"),
]


@pytest.mark.parametrize("arguments", FINE, ids=lambda given: given[0])
def test_every_command_takes_such_a_name(
    arguments: tuple[str, ...], home: Home, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In this process, with streams as a process of the command line has them."""
    monkeypatch.chdir(home.folder)
    written = [BytesIO(), BytesIO()]
    for name, buffer in zip(("stdout", "stderr"), written, strict=True):
        stream = TextIOWrapper(buffer, "utf-8", "backslashreplace", write_through=True)
        monkeypatch.setattr(sys, name, stream)
    code = run_here(arguments)
    said = b"".join(buffer.getvalue() for buffer in written).decode()
    assert "Traceback" not in said
    assert code in (0, 7), said  # a plan that fails when it is carried out is a result


WHERE_NOTHING_IS = [
    *((command, f"{NAME}?") for command in ("check", "view", "plot", "execute", "video")),
    *((command, f"{NAME}?") for command in ("simulate", "examine", "describe", "equations", "new")),
    *(("equations", f"{NAME}?{ending}") for ending in (".toml", ".yaml", ".json", ".py", ".py:f")),
    (f"{NAME}?",),
    ("pendulum", "--planner", NAME),
    (f"{NAME}.toml", "--set", f"{NAME}=1"),
    (f"{NAME}.toml", "--roadmap", NAME),
    ("simulate", "pendulum", "--inputs", NAME),
    ("simulate", "pendulum", "--start", f"{NAME}=1"),
    ("list", "planners", NAME),
]


@pytest.fixture
def said(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Sayer:
    """Run a command in this process, in some folder, and return its code and what it said."""

    def run(folder: Path, *arguments: str) -> tuple[int, str]:
        monkeypatch.chdir(folder)
        code = run_here(arguments)
        said = capsys.readouterr()
        return code, said.out + said.err

    return run


@pytest.mark.parametrize("arguments", WHERE_NOTHING_IS, ids=ascii)
def test_where_nothing_has_such_a_name_a_sentence_says_so(
    arguments: tuple[str, ...], home: Home, said: Sayer
) -> None:
    code, words = said(home.folder, *arguments)
    assert code == 2, words
    assert "error: " in words
    assert "Traceback" not in words


def test_a_gallery_says_which_run_is_not_there(tmp_path: Path, said: Sayer) -> None:
    code, words = said(tmp_path, "gallery", f"{NAME}?")
    assert code == 7, words
    assert "damaged" in words


BYTES = {
    "no UTF-8": b'{"name": "\xff"}',
    "half a character": b'{"name": "\\ud800", "schema": 1}',
    "a zero": b"\0",
    "UTF-16": "schema = 1".encode("utf-16"),
}


@pytest.mark.parametrize("content", BYTES.values(), ids=BYTES)
def test_files_of_other_bytes_are_refused_by_every_command(
    content: bytes, tmp_path: Path, said: Sayer
) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    for name in ("scenario.toml", "report.json", "trajectory.csv"):
        (folder / name).write_bytes(content)
    names = [f"own.{ending}" for ending in ("toml", "yaml", "json", "py")]
    for name in (*names, "own.csv"):
        (tmp_path / name).write_bytes(content)
    whats = [("equations", "describe", "examine", "simulate"), names]
    runs = [("check", "plot", "execute", "view", "video"), ["run"]]
    tried = [*product(*whats), *product(*runs), ("own.toml",)]
    for arguments in (*tried, ("simulate", "pendulum", "--inputs", "own.csv")):
        code, words = said(tmp_path, *arguments)
        assert code == 2, (arguments, words)
        assert "Traceback" not in words
    assert said(tmp_path, "gallery", "run")[0] == 7
