"""Rows as they come, in a file to which whole lines are added: no crash loses one.

A line that a crash has cut is taken off before the next one is added.
"""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, Self

from kinolab.errors import InputError, KinolabError, Mistake
from kinolab.studies.columns import Row, fits
from kinolab.untrusted import BYTES, json_of

ROWS = "rows.jsonl"


class FullError(KinolabError):
    """A row could not be written."""

    exit_code = 6


class Journal:
    """The rows of a folder, open for more; one process at a time has it.

    Raises:
        InputError: If another process has it.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / ROWS
        self._lock = os.open(folder / ".lock", os.O_RDWR | os.O_CREAT, 0o600)
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(self._lock)
            what = "another process runs this study."
            remedy = "Wait for it, or name another --out."
            raise InputError([Mistake(str(folder), what, remedy)]) from None
        except OSError:
            pass  # this file system has no locks
        whole = read = 0
        for line in _lines(self._path):
            read += len(line)
            whole = read if line.endswith(b"\n") else whole
        self._handle = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o644)
        os.ftruncate(self._handle, whole)
        self._end = whole

    def add(self, row: Row) -> None:
        """Add a row.

        Raises:
            FullError: If it cannot be written; the rows before it stay.
        """
        line = (json.dumps(row, allow_nan=False) + "\n").encode()
        try:
            written = os.pwrite(self._handle, line, self._end)
            if written < len(line):
                raise OSError("there is no room for a row")
        except OSError as error:
            os.ftruncate(self._handle, self._end)
            reason = error.strerror or str(error)
            what = f"{self._path}: {reason}. Rows so far are kept; --resume goes on."
            raise FullError(what) from error
        self._end += len(line)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._handle)
        os.close(self._lock)


def read_rows(folder: Path) -> list[dict[str, Any]]:
    """Return the rows of a folder; a line that a crash has cut is left out.

    Raises:
        InputError: If a line is damaged.
    """
    rows = []
    for number, line in enumerate(_lines(folder / ROWS), start=1):
        if not line.endswith(b"\n") and len(line) <= BYTES["json"]:
            break  # it was cut
        try:
            row = json_of(line) if len(line) <= BYTES["json"] else None
        except (ValueError, RecursionError):
            row = None
        if row is None or not fits(row):
            where, what = f"{folder / ROWS} line {number}", "this line is damaged."
            raise InputError([Mistake(where, what, "Remove it; its run is then made again.")])
        rows.append(row)
    return rows


def first_rows(rows: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the first row of each run."""
    found: dict[int, dict[str, Any]] = {}
    for row in rows:
        found.setdefault(row["index"], row)
    return list(found.values())


def _lines(path: Path) -> Iterator[bytes]:
    """Yield lines, the last one even if it was cut; what is longer than a line may be, in parts."""
    if path.is_file():
        with path.open("rb") as file:
            while line := file.readline(BYTES["json"] + 1):
                yield line
