"""Temporary files: none stays, whatever becomes of the process that wrote it; locks of folders."""

from __future__ import annotations

import subprocess
import sys
import threading
from pathlib import Path

import pytest

from kinolab.files import discard_abandoned, only_writer, whole_file, write_whole
from tests.support import environment

UNDER_WAY = """
import sys
from pathlib import Path
from kinolab.files import whole_file
with whole_file(Path("table.csv")) as file:
    file.write(b"half")
    file.flush()
    print("under way", flush=True)
    sys.stdin.read()
"""
ANOTHER = (
    "from pathlib import Path; from kinolab.files import write_whole; write_whole(Path('b'), b'')"
)


def begun(folder: Path) -> subprocess.Popen[bytes]:
    """Start a process that writes a file, and wait until half of it is written."""
    process = subprocess.Popen(
        [sys.executable, "-c", UNDER_WAY],
        cwd=folder,
        env=environment(),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == b"under way\n"
    return process


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_what_a_killed_process_left_is_removed_by_the_next_one(tmp_path: Path) -> None:
    process = begun(tmp_path)
    (tmp_path / ".mine.1a2b3c4d").write_text("mine")
    process.kill()
    process.communicate()
    (left,) = (name for name in names(tmp_path) if name.startswith(".table.csv."))
    assert (tmp_path / left).read_bytes() == b"half"
    subprocess.run([sys.executable, "-c", ANOTHER], cwd=tmp_path, env=environment(), check=True)
    assert names(tmp_path) == [".mine.1a2b3c4d", "b"]


def test_what_is_being_written_is_left_alone(tmp_path: Path) -> None:
    process = begun(tmp_path)
    discard_abandoned(tmp_path)
    process.communicate(b"end", timeout=30)
    assert process.returncode == 0
    assert names(tmp_path) == ["table.csv"]
    assert (tmp_path / "table.csv").read_bytes() == b"half"


def test_nothing_is_left_of_a_file_that_failed(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), whole_file(tmp_path / "a") as file:
        file.write(bytes(1 // 0))
    assert names(tmp_path) == []


@pytest.mark.skipif(sys.platform == "win32", reason="there are no such locks")
def test_a_folder_has_one_writer_at_a_time(tmp_path: Path) -> None:
    def write() -> None:
        with only_writer(tmp_path):
            write_whole(tmp_path / "a", b"second")

    second = threading.Thread(target=write)
    with only_writer(tmp_path):
        second.start()
        second.join(0.3)  # long enough to write, if it were let
        write_whole(tmp_path / "a", b"first")
    second.join()
    assert (tmp_path / "a").read_bytes() == b"second"
    assert names(tmp_path) == ["a"]  # and the lock leaves no file
