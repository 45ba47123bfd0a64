"""What is kept is found again as it was, by all that determines it, and made once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinolab.store import digest_of, pack_arrays, pickled, unpack_arrays
from tests.support import ROOT

NUMBERS = pickled("numbers", tuple)


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("KINOLAB_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def counted(made: list[int]) -> Callable[[], tuple[int, ...]]:
    def make() -> tuple[int, ...]:
        made.append(len(made))
        return (len(made),)

    return make


def test_what_is_there_is_not_made_again() -> None:
    made: list[int] = []
    assert NUMBERS.find(["a"]) is None
    assert [NUMBERS.get(["a"], counted(made)) for _ in range(3)] == [(1,)] * 3
    assert NUMBERS.get(["b"], counted(made)) == (2,)
    assert NUMBERS.find(["a"]) == (1,)


def test_contents_that_are_the_same_when_joined_are_told_apart() -> None:
    parts: list[list[str | bytes]] = [["ab", "c"], ["a", "bc"], ["abc"], ["abc", ""], [b"ab", "d"]]
    assert len({digest_of(*some) for some in parts}) == len(parts)
    assert digest_of("ä", "b") == digest_of("ä".encode(), b"b")


def test_other_code_makes_another_entry(tmp_path: Path) -> None:
    (tmp_path / "one.py").write_text("a = 1")
    (tmp_path / "two.py").write_text("a = 2")
    kinds = [replace(NUMBERS, made_by=(tmp_path / name,)) for name in ("one.py", "two.py")]
    kinds[0].keep(["a"], (1,))
    assert [kind.find(["a"]) for kind in kinds] == [(1,), None]


def test_an_entry_of_another_class_is_made_anew(caplog: pytest.LogCaptureFixture) -> None:
    pickled("numbers", list).keep(["a"], [1])
    assert NUMBERS.find(["a"]) is None
    assert "was damaged; it is made anew" in caplog.text
    assert not NUMBERS.path(["a"]).exists()


def test_those_unused_for_longest_make_room(home: Path) -> None:
    small = replace(NUMBERS, most=1)
    for k in range(3):
        small.keep([str(k)], (k,))
        assert [*home.iterdir()] == [small.path([str(k)])]


ARRAYS: list[Any] = [
    *(np.float64(0.5), np.zeros((0, 3)), np.arange(6).reshape(2, 3).T, np.array([True])),
    np.float32([[1.0, -0.0]]),
]


def test_arrays_are_what_they_were_and_may_be_written_to() -> None:
    types = [array.dtype.type for array in ARRAYS]
    found = unpack_arrays(memoryview(bytearray(pack_arrays(ARRAYS))), *types)
    for array, before in zip(found, ARRAYS, strict=True):
        np.testing.assert_array_equal(array, before)
        assert array.shape == np.shape(before)
        assert array.flags.writeable


@pytest.mark.parametrize(
    ("content", "types"),
    [
        (pack_arrays([np.zeros(2)]), (np.float32,)),
        (pack_arrays([np.zeros(2)]), (np.float64, np.float64)),
        (pack_arrays([np.zeros(2)] * 2), (np.float64,)),
        (pack_arrays([np.zeros(2)])[:-1], (np.float64,)),
        (pack_arrays([np.zeros(2)]) + b"x", (np.float64,)),
        (b"", (np.float64,)),
    ],
)
def test_other_arrays_are_refused(content: bytes, types: tuple[type[np.generic], ...]) -> None:
    with pytest.raises(ValueError):  # noqa: PT011  (NumPy's own, or ours)
        unpack_arrays(memoryview(content), *types)


def test_only_the_store_knows_where_entries_are() -> None:
    """Others name kinds; compiled loops have numba's own folders."""
    allowed = {"store.py", "files.py", "numerics/jit_cache.py"}
    package = ROOT / "src" / "kinolab"
    found = {
        str(path.relative_to(package))
        for path in package.rglob("*.py")
        if "write_sealed" in path.read_text(encoding="utf-8")
    }
    assert found == allowed
