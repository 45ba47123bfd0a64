"""The script of ten thousand faults sees what it is meant to see: each judgement of it can fail."""

from __future__ import annotations

import io
import json
import os
import random
import signal
import struct
import sys
import time
import tomllib
import zipfile
from pathlib import Path

import pytest
from PIL import Image

from benchmarks.fault_kinds import KINDS, damaged_caches, kills, plain_data, sandbox
from benchmarks.fault_kinds.sandbox import Ended
from benchmarks.fault_kinds.storage import gone
from benchmarks.fault_kinds.whole_files import broken, drafts
from benchmarks.fault_kinds.workshop import Verdict
from kinolab.runs import write_run
from tests.conftest import Solved
from tests.support import environment

pytestmark = pytest.mark.skipif(not Path("/proc").is_dir(), reason="processes are read in /proc")


def test_there_are_ten_thousand() -> None:
    assert sum(kind.count for kind in KINDS) >= 10_000
    assert len({kind.name for kind in KINDS}) == len(KINDS)


# --- files ---


@pytest.fixture
def folder(short: Solved, tmp_path: Path) -> Path:
    """A run, with pictures as short as they may be."""
    place = tmp_path / "run"
    write_run(place, short.problem, short.plan)
    (place / "scene.html").write_text("<html><body>here</body></html>\n")
    (place / "result.glb").write_bytes(b"glTF" + struct.pack("<II", 2, 20) + bytes(8))
    Image.new("P", (8, 8)).save(place / "animation.gif")
    return place


def test_a_finished_run_is_whole(folder: Path) -> None:
    assert broken(folder) == []
    assert drafts(folder) == []


@pytest.mark.parametrize(
    "name",
    [
        "trajectory.csv", "trajectory.npz", "report.json", "scenario.toml", "search.npz",
        "README.txt", "scene.html", "animation.gif", "result.glb", "assets/machine.json",
    ],
)  # fmt: skip
def test_no_beginning_of_a_file_passes_for_the_whole(name: str, folder: Path) -> None:
    content = (folder / name).read_bytes()
    (folder / name).write_bytes(content[: len(content) // 2])
    assert any(told.startswith((name, Path(name).name)) for told in broken(folder))


@pytest.mark.parametrize("name", ["trajectory.csv", "scenario.toml", "assets/machine.json"])
def test_a_report_vouches_for_what_must_be_there(name: str, folder: Path) -> None:
    (folder / name).unlink()
    assert f"{name}: missing" in broken(folder)


def test_what_another_run_left_is_seen(folder: Path) -> None:
    (folder / "assets" / "2_another.stl").write_bytes(b"another's")
    assert broken(folder) == ["assets/2_another.stl: of no run"]


@pytest.mark.parametrize("name", ["movie.mp4", "plot.svg", "plot.png", "results.parquet"])
def test_what_is_no_such_file_is_not_whole(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(b"PAR1 <svg> half")
    assert len(broken(tmp_path)) == 1


def test_temporary_files_are_seen(tmp_path: Path) -> None:
    (tmp_path / "plots").mkdir()
    (tmp_path / "plots" / ".states.svg.0123abcd.draft").write_text("half")
    assert len(drafts(tmp_path)) == 1


# --- commands ---


def ended(arguments: list[str], tmp_path: Path, limit: float = 60.0) -> Ended:
    """Run a command in an interpreter of its own: a test does not fork what pytest has loaded."""
    return sandbox.run(
        arguments, tmp_path, tmp_path / "scratch", limit, environment=environment(), fresh=True
    )


def test_a_command_is_told_by_its_exit_code_and_its_words(tmp_path: Path) -> None:
    told = ended(["check", "nowhere"], tmp_path)
    assert told.code == 2
    assert "error: nowhere" in told.err
    verdict = Verdict("a folder that is not there")
    verdict.heard(told, [2])
    assert verdict.sound
    verdict.heard(told, [0])
    assert not verdict.sound


def test_a_command_beyond_its_time_is_killed_and_counted(tmp_path: Path) -> None:
    told = ended(["list"], tmp_path, limit=0.01)
    assert told.code is None
    verdict = Verdict("haste")
    verdict.heard(told)
    assert verdict.late == 1


def test_a_command_that_has_not_begun_within_its_time_is_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def become(*_: object) -> None:  # without a group of its own
        time.sleep(60)
        os._exit(0)

    monkeypatch.setattr(sandbox, "_become", become)
    assert ended(["list"], tmp_path, limit=0.05).code is None


def test_processes_that_stay_are_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sleep = "[sys.executable, '-c', 'import time; time.sleep(60)']"
    stay = f"import subprocess, sys; subprocess.Popen({sleep})"
    monkeypatch.setattr(sandbox, "ENTER", stay)
    monkeypatch.setattr(sandbox, "LEAVE", 0.2)
    assert ended([], tmp_path).orphans == 1


def test_a_signal_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sandbox, "ENTER", "import time; time.sleep(60)")
    command = sandbox.start(
        [], tmp_path, tmp_path / "scratch", environment=environment(), fresh=True
    )
    time.sleep(0.1)
    command.send(signal.SIGKILL)
    assert command.ended(30.0).code == -signal.SIGKILL


@pytest.mark.parametrize(
    "err", ["Traceback (most recent call last):\n", "Exception ignored in: <x>\n"]
)
def test_a_traceback_is_seen_whatever_the_exit_code(err: str) -> None:
    verdict = Verdict("a mistake")
    verdict.heard(Ended(0, "", err, 0.1), [0])
    assert verdict.tracebacks == 1


# --- what is done to files ---


@pytest.mark.parametrize("how", [how for how in damaged_caches.DAMAGES if how != "forbidden"])
def test_a_damaged_entry_is_not_what_it_was(how: str, tmp_path: Path) -> None:
    path, other = tmp_path / "entry", tmp_path / "other"
    whole = b"magic\n" + bytes(range(256)) * 4
    path.write_bytes(whole)
    other.write_bytes(whole[::-1])
    damaged_caches.damage(path, how, other, random.Random(how))
    assert not path.is_file() or path.read_bytes() != whole


def test_hostile_data_can_be_written_and_is_something_else() -> None:
    tree = {"schema": 1, "goal": {"x": 1.0}, "world": {"obstacle": [{"box": [1.0, 2.0, 3.0]}]}}
    rng, changed = random.Random(1), 0
    for _ in range(300):
        hostile = plain_data.mutate(tree, rng)
        changed += json.dumps(hostile) != json.dumps(tree)
        assert isinstance(plain_data.toml(hostile), str)
        assert isinstance(plain_data.spoil(json.dumps(tree).encode(), rng), bytes)
    assert changed > 270
    assert tomllib.loads(plain_data.toml(tree)) == tree


def test_all_commands_that_are_killed_have_words() -> None:
    for name, (_, on_run) in kills.COMMANDS.items():
        words = kills.words_of(name, Path("folder"))
        assert Path("folder") in words
        assert (words[1] == Path("folder")) == on_run


def test_a_damaged_archive_is_not_whole(tmp_path: Path) -> None:
    """One byte of an array, which leaves the archive's list of contents alone."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr("a", bytes(100))
    content = bytearray(out.getvalue())
    content[60] ^= 1
    (tmp_path / "a.npz").write_bytes(content)
    assert broken(tmp_path) == ["a.npz: not whole"]


def test_the_tally_adds_up() -> None:
    sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
    try:
        import faults
    finally:
        sys.path.pop(0)
    entry = {
        "tracebacks": 1,
        "partial": ["a", "b"],
        "wrong": [],
        "late": 0,
        "total": 1.0,
        "cpu": 0.5,
    }
    tally = {(KINDS[0].name, 0): entry, (KINDS[1].name, 0): {**entry, "partial": []}}
    rows = faults.table(list(KINDS), tally)
    assert rows[-1] == ["all", 2, 2, 2, 0, 0, 2, 0]


def test_only_a_file_that_is_not_there_is_excused_where_folders_are_removed(tmp_path: Path) -> None:
    (tmp_path / "assets").mkdir()
    (tmp_path / "assets" / "maze.stl").write_text("half")
    assert gone(tmp_path, "trajectory.csv: missing")
    assert gone(tmp_path, "assets/machine.json: not the report's")
    assert not gone(tmp_path, "assets/maze.stl: not the report's")
    assert not gone(tmp_path, "trajectory.csv: not whole")
