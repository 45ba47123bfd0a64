"""Files with a checksum: what was written, or nothing; whatever lies there is never waited for."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.dynamics.codegen.cache import OBJECTS, compiled
from kinolab.dynamics.codegen.mode_formulas import FORMULAS
from kinolab.dynamics.model.enclosures import Enclosures
from kinolab.files import MOST_KEPT, FileLock, read_sealed, write_sealed
from kinolab.numerics.intervals import IntervalArray
from kinolab.world import box_obstacle
from kinolab.world.distances import distance_field_cache
from kinolab.world.distances.distance_field_cache import cached_distance_field
from tests.support import within

MAGIC, CONTENT = b"a test 1\n", bytes(range(256)) * 3


@pytest.fixture
def entry(tmp_path: Path) -> Path:
    path = tmp_path / "cache" / "entry"
    write_sealed(path, MAGIC, CONTENT)
    assert read_sealed(path, MAGIC) == CONTENT
    return path


def test_no_change_of_a_byte_passes(entry: Path, caplog: pytest.LogCaptureFixture) -> None:
    whole = entry.read_bytes()
    for place in range(len(whole)):
        changed = bytearray(whole)
        changed[place] ^= 1 + place % 255
        entry.write_bytes(changed)
        assert read_sealed(entry, MAGIC) is None, place
        assert not entry.exists()
    assert len(caplog.records) == len(whole)


@pytest.mark.parametrize("kept", [0, 1, 8, 9, 40, 41, 42, 500])
def test_no_beginning_passes_for_the_whole(kept: int, entry: Path) -> None:
    entry.write_bytes(entry.read_bytes()[:kept])
    assert read_sealed(entry, MAGIC) is None
    assert not entry.exists()


def test_what_is_not_there_is_no_damage(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "file").write_text("")
    assert read_sealed(tmp_path / "entry", MAGIC) is None
    assert read_sealed(tmp_path / "file" / "entry", MAGIC) is None
    assert not caplog.records


def test_a_file_that_claims_to_be_huge_is_not_read(
    entry: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Its length is all that there is of it: a hole of a terabyte takes no room on disk."""
    os.truncate(entry, 2**40)
    assert MOST_KEPT < 2**40
    assert read_sealed(entry, MAGIC) is None
    assert not entry.exists()
    assert len(caplog.records) == 1


def a_machine() -> bytes:
    return kinolab.systems.get("pendulum").model().f([0.4, -0.7], [0.3]).tobytes()


def bounds_of_a_machine() -> bytes:
    x, u = np.array([[0.4, -0.7]]), np.array([[0.3]])
    bounds = Enclosures(kinolab.systems.get("pendulum").model())
    return bounds.speed(IntervalArray(x, x + 0.1), u).tobytes()


def a_grid() -> bytes:
    return cached_distance_field((box_obstacle("box", (1.0, 1.0, 1.0)),), 0.1).distance.tobytes()


def machine_as_javascript() -> bytes:
    from kinolab.dynamics.javascript import javascript_of

    return javascript_of(kinolab.systems.get("pendulum").model()).encode()


def object_code() -> bytes:
    return compiled("define double @one() {\n  ret double 1.0\n}")


# What reads a machine's code, but not its formulas; object code is read where there is none of it.
WITHOUT_FORMULAS = (a_machine, machine_as_javascript)
MAKERS = [a_machine, bounds_of_a_machine, a_grid, machine_as_javascript, object_code]


@pytest.mark.parametrize("make", MAKERS)
def test_whatever_becomes_of_an_entry_it_is_made_anew(
    make: Callable[[], bytes],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    """A flipped byte at some places, and a pipe, to which nobody will ever write."""
    home, draw = tmp_path / "cache", np.random.default_rng(1)
    monkeypatch.setenv("KINOLAB_CACHE", str(home))
    monkeypatch.setattr(distance_field_cache, "MIN_CELLS", 1)
    expected = make()
    entries = {path: path.read_bytes() for path in home.iterdir()}
    unread = {f".{OBJECTS.name}"} if make is not object_code else set()
    unread |= {f".{FORMULAS.name}"} if make in WITHOUT_FORMULAS else set()
    entries = {path: whole for path, whole in entries.items() if path.suffix not in unread}
    for path, whole in entries.items():
        for place in draw.integers(len(whole), size=4):
            path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
            caplog.clear()
            with within(60):
                assert make() == expected
            assert [str(path) in message for message in caplog.messages] == [True]
        path.unlink()
        os.mkfifo(path)
        with within(60):
            assert make() == expected
        assert {path: path.read_bytes() for path in home.iterdir() if path in entries} == entries
        assert not list(home.glob(".*"))  # no draft is left


def test_a_lock_is_held_by_one_until_it_is_released(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As between processes: each opens the file for itself."""
    monkeypatch.setattr("kinolab.files.LONGEST_WAIT", 0.05)  # [s]
    one, other = (FileLock(tmp_path / "a" / "lock") for _ in range(2))
    assert one.acquire()
    assert not one.acquire()  # it is held already
    assert not other.acquire()
    one.release()
    assert other.acquire()
    other.release()


def test_where_no_file_can_be_made_nobody_waits_for_a_lock(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    lock = FileLock(tmp_path / "file" / "lock")
    assert not lock.acquire()
    lock.release()
