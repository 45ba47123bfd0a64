"""Compiled loops on disk: whatever happens to their files, what they compute is right."""

from __future__ import annotations

import importlib
import logging
import os
import pkgutil
import subprocess
import sys
from collections.abc import Callable
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba.core import config
from numba.core.caching import NullCache
from numba.core.dispatcher import Dispatcher

import kinolab
from tests.support import environment, needs, within

LOOPS = """
from kinolab.numerics.jit import kernel

@kernel
def gauss(n):
    total = 0
    for k in range(n + 1):
        total += k
    return total
"""
DOUBLE = """
from kinolab.numerics.jit import kernel

@kernel
def gauss(x):
    return x + x
"""
SOUND = 5050, 500500  # n (n + 1) / 2 for 100 and 1000


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with loops, which are kept in ``cache`` beside them."""
    (tmp_path / "loops.py").write_text(LOOPS)
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "cache"))
    assert computed(tmp_path)[0] == SOUND
    return tmp_path


def loops(home: Path) -> Any:
    """The loops as a new process would have them."""
    specification = spec_from_file_location("loops", home / "loops.py")
    assert specification is not None
    assert specification.loader is not None
    module = module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def computed(home: Path) -> tuple[tuple[int, int], bool]:
    """What the loops of a new process would compute, and whether they came from disk."""
    module = loops(home)
    with within(60):
        values = module.gauss(100), module.gauss(1000)
    return values, bool(module.gauss.stats.cache_hits)


def entries(home: Path) -> list[Path]:
    """The index and the machine code."""
    found = sorted((home / "cache").rglob("*.sealed*.nb[ic]"))
    assert [path.suffix for path in found] == [".nbc", ".nbi"]
    return found


def test_what_was_compiled_is_read_by_the_next_process(home: Path) -> None:
    assert computed(home) == (SOUND, True)


def test_another_text_is_compiled_anew_without_a_word(
    home: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Of another length: Python's own bytecode knows a text by its length and its second."""
    (home / "loops.py").write_text(LOOPS.replace("total = 0", "total = 70"))
    values, from_disk = computed(home)
    assert values == (SOUND[0] + 70, SOUND[1] + 70)
    assert not from_disk
    assert not caplog.records


@pytest.mark.parametrize("which", [0, 1], ids=["machine code", "index"])
def test_a_byte_that_flips_anywhere_changes_no_result(
    which: int, home: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """The first and the last byte, and others at random."""
    whole = entries(home)[which].read_bytes()
    draw = np.random.default_rng(1)
    for place in (0, len(whole) - 1, *draw.integers(len(whole), size=8)):
        changed = bytearray(whole)
        changed[place] ^= int(draw.integers(1, 256))
        entries(home)[which].write_bytes(changed)
        caplog.clear()
        assert computed(home) == (SOUND, False), place
        assert len(caplog.records) == 1
        assert computed(home) == (SOUND, True), place  # mended
        assert len(caplog.records) == 1


def zeroed(content: bytes) -> bytes:
    """A block of a file that was never written before the power went."""
    return (
        content[: len(content) // 3] + bytes(len(content) // 3) + content[len(content) // 3 * 2 :]
    )


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda _: b"",
    "truncated": lambda content: content[: len(content) // 2],
    "without its last byte": lambda content: content[:-1],
    "longer": lambda content: content + b"\0",
    "all zeros": lambda content: bytes(len(content)),
    "with a block of zeros": zeroed,
    "text": lambda _: b"nothing of the kind",
    "a pickle of something else": lambda _: b"\x80\x04K\x01.",
}


@pytest.mark.parametrize("which", [0, 1], ids=["machine code", "index"])
@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_damaged_entry_is_compiled_anew(
    which: int, damage: Callable[[bytes], bytes], home: Path, caplog: pytest.LogCaptureFixture
) -> None:
    entry = entries(home)[which]
    entry.write_bytes(damage(entry.read_bytes()))
    assert computed(home) == (SOUND, False)
    (said,) = caplog.messages
    assert said == f"warning: {entry} was damaged; it is made anew."
    assert computed(home) == (SOUND, True)


def a_pipe(path: Path) -> None:
    os.mkfifo(path)


def a_folder(path: Path) -> None:
    path.mkdir()


def a_folder_with_something_in_it(path: Path) -> None:
    path.mkdir()
    (path / "mine.txt").write_text("kept")


def a_link_to_itself(path: Path) -> None:
    path.symlink_to(path)


def a_link_to_endless_zeros(path: Path) -> None:
    path.symlink_to("/dev/zero")


STRANGERS = [a_pipe, a_folder, a_link_to_itself, a_link_to_endless_zeros]


@pytest.mark.parametrize("which", [0, 1], ids=["machine code", "index"])
@pytest.mark.parametrize("stranger", STRANGERS)
def test_what_is_no_file_is_removed(
    which: int, stranger: Callable[[Path], None], home: Path, caplog: pytest.LogCaptureFixture
) -> None:
    entry = entries(home)[which]
    entry.unlink()
    stranger(entry)
    assert computed(home) == (SOUND, False)
    assert len(caplog.records) == 1
    assert computed(home) == (SOUND, True)
    assert entry.is_file()


@pytest.mark.parametrize("which", [0, 1], ids=["machine code", "index"])
def test_a_folder_with_something_in_it_stays(which: int, home: Path) -> None:
    entry = entries(home)[which]
    entry.unlink()
    a_folder_with_something_in_it(entry)
    for _ in range(2):
        assert computed(home) == (SOUND, False)
    assert (entry / "mine.txt").read_text() == "kept"
    assert [path for path in entry.parent.iterdir() if path.name.startswith(".")] == []


def test_an_entry_under_the_name_of_another_signature_is_not_taken(home: Path) -> None:
    """Two processes that save at once may choose the same name."""
    (home / "loops.py").write_text(DOUBLE)
    assert doubled(home) == (4, 0.5)
    codes = sorted((home / "cache").rglob("*.nbc"))
    first, second = codes[-2:]
    first.write_bytes(second.read_bytes())
    assert doubled(home) == (4, 0.5)


def doubled(home: Path) -> tuple[int, float]:
    """What the loops of a new process would compute of two types."""
    module = loops(home)
    return module.gauss(2), module.gauss(0.25)


@needs("gymnasium", "yourdfpy")
def test_everything_that_is_compiled_is_kept_with_a_checksum() -> None:
    for module in pkgutil.walk_packages(kinolab.__path__, "kinolab."):
        importlib.import_module(module.name)
    compiled = {
        value
        for name, module in list(sys.modules.items())
        if name.partition(".")[0] == "kinolab"
        for value in vars(module).values()
        if isinstance(value, Dispatcher)
    }
    caches = {type(f._cache).__module__ for f in compiled if not isinstance(f._cache, NullCache)}
    assert caches == {"kinolab.numerics.jit_cache"}


def test_where_no_folder_can_be_written_loops_are_compiled_each_time(tmp_path: Path) -> None:
    """A file where a folder should be refuses everyone, root too."""
    (tmp_path / "loops.py").write_text(LOOPS + "print(gauss(100), gauss.stats.cache_hits)")
    (tmp_path / "__pycache__").write_text("")
    nowhere = str(tmp_path / "__pycache__" / "cache")
    places = {"NUMBA_CACHE_DIR": nowhere, "XDG_CACHE_HOME": nowhere, "HOME": nowhere}
    done = subprocess.run(
        [sys.executable, "-B", tmp_path / "loops.py"],
        env=environment(**places), capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.stderr == ""
    assert done.stdout.split()[0] == "5050"


def test_a_warning_is_one_line_on_stderr(home: Path) -> None:
    command = [sys.executable, "-c", "from loops import gauss; print(gauss(100))"]
    places = environment(NUMBA_CACHE_DIR=str(home / "cache"))

    def done() -> tuple[str, str]:
        run = subprocess.run(
            command, cwd=home, env=places, capture_output=True, text=True, check=True
        )
        return run.stdout, run.stderr

    for path in (home / "cache").rglob("*.sealed.*.nbc"):
        path.write_bytes(b"")
    out, said = done()
    assert out == "5050\n"
    assert said.startswith("warning: ")
    assert said.count("\n") == 1
    assert done() == ("5050\n", "")
    assert logging.getLogger("kinolab").handlers == []  # who uses the library decides
