"""Rows are kept whole: after a crash, on a full disk, and with one process at a time."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

from kinolab.errors import InputError
from kinolab.studies.journal import FullError, Journal, first_rows, read_rows
from kinolab.studies.run_study import StudyFolder
from tests.studies.tiny_study import LIMITED, SWINGS, kept, row, rows_made, study_in, written
from tests.support import environment

FULL = """
import resource, signal, sys
from pathlib import Path
from kinolab.studies.journal import FullError, Journal
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
with Journal(Path(sys.argv[1])) as journal:
    try:
        for index in range(100):
            journal.add({"index": index, "filling": "x" * 100})
    except FullError as error:
        print(error)
"""


def test_what_is_added_is_read_in_its_order(tmp_path: Path) -> None:
    rows = [row(3, "a\nb"), row(1), row(2)]
    with Journal(tmp_path) as journal:
        for one in rows:
            journal.add(one)
    assert read_rows(tmp_path) == kept(tmp_path) == rows


def test_a_line_that_was_cut_is_left_out_and_overwritten(tmp_path: Path) -> None:
    written(tmp_path, [row(0), row(1)])
    path = tmp_path / "rows.jsonl"
    path.write_bytes(path.read_bytes()[:-7])
    assert read_rows(tmp_path) == [row(0)]
    path.write_bytes(path.read_bytes() + b"x" * 10_000)  # longer than the row that comes next
    with Journal(tmp_path) as journal:
        journal.add(row(2))
    assert kept(tmp_path) == [row(0), row(2)]


@pytest.mark.parametrize(
    "damage",
    [
        *('{"index": 1, "tas', "\0\0\0", "[1]", '{"index": "1"}', "[" * 10**5, '{"index": 1}'),
        *(json.dumps(row(1, solved=1)), json.dumps(row(1, versions="{")), json.dumps(row(True))),
        *(json.dumps(row(1, host="\ud800")), json.dumps(row(1, improvements=[[1.0]]))),
        *(json.dumps(row(1, status=None)), json.dumps(row(2**63))),
        *(json.dumps(row(1, search=value)) for value in (math.nan, math.inf)),
    ],
)
def test_a_damaged_line_in_the_middle_is_named(tmp_path: Path, damage: str) -> None:
    written(tmp_path, [row(0), row(1), row(2)])
    path = tmp_path / "rows.jsonl"
    lines = path.read_text().splitlines()
    path.write_text("\n".join([lines[0], damage, lines[2], ""]))
    with pytest.raises(InputError) as caught:
        read_rows(tmp_path)
    assert str(caught.value) == (
        f"{path} line 2: this line is damaged. Remove it; its run is then made again."
    )


def test_a_full_disk_leaves_whole_lines_only(tmp_path: Path) -> None:
    """Each row has 128 bytes: seven fit into 1000."""
    done = subprocess.run(
        [sys.executable, "-c", FULL, str(tmp_path)],
        env=environment(), capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert "Rows so far are kept; --resume goes on." in done.stdout
    assert [one["index"] for one in kept(tmp_path)] == [*range(7)]
    with Journal(tmp_path) as journal:
        journal.add(row(7))
    assert [one["index"] for one in kept(tmp_path)] == [*range(8)]


def test_a_row_that_is_written_in_part_is_taken_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written(tmp_path, [row(0)])
    whole = os.pwrite
    with Journal(tmp_path) as journal:
        monkeypatch.setattr(os, "pwrite", lambda handle, line, at: whole(handle, line[:9], at))
        with pytest.raises(FullError, match="there is no room for a row"):
            journal.add(row(1))
        monkeypatch.undo()
        journal.add(row(2))
    assert kept(tmp_path) == [row(0), row(2)]


def test_one_process_at_a_time_has_a_folder(tmp_path: Path) -> None:
    told = "another process runs this study. Wait for it, or name another --out."
    with Journal(tmp_path), pytest.raises(InputError) as caught, Journal(tmp_path):
        pass
    assert str(caught.value) == f"{tmp_path}: {told}"
    opening = "from pathlib import Path; from kinolab.studies.journal import Journal; import sys; "
    code = f"{opening}Journal(Path(sys.argv[1])).__enter__()"
    with Journal(tmp_path):
        done = subprocess.run(
            [sys.executable, "-c", code, str(tmp_path)],
            env=environment(), capture_output=True, text=True, check=False,
        )  # fmt: skip
    assert told in done.stderr
    with Journal(tmp_path):
        pass


def test_a_process_that_was_just_before_leaves_nothing_to_do(tmp_path: Path) -> None:
    """Its rows are those of the folder, although they came after the study was read."""
    study, out = study_in(tmp_path, SWINGS + LIMITED), tmp_path / "out"
    late = StudyFolder(study, out)
    rows = rows_made(study, out)

    def never(*_: object) -> None:
        raise AssertionError("no run is missing")

    assert late.run(never)  # type: ignore[arg-type]
    assert kept(out) == rows


def test_the_first_row_of_a_run_counts() -> None:
    assert first_rows([row(1, "a"), row(0), row(1, "b")]) == [row(1, "a"), row(0)]
