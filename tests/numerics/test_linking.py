"""Compiled functions that are kept as LLVM IR, and as machine code only where Python calls them."""

from __future__ import annotations

import importlib.util
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from numba.core import config
from numba.core.errors import TypingError

from kinolab.numerics import jit
from tests.support import environment

LOOPS = """
from kinolab.numerics.jit import allocating_kernel, kernel

@kernel
def square(n):
    return n * n

@kernel
def pyramid(n):
    total = 0
    for k in range(n + 1):
        total += square(k)
    return total

@allocating_kernel
def assign(values, first):
    values[:2] = first

@allocating_kernel
def assigned(values, first):
    assign(values, first)
    return values.sum()
"""
PYRAMID = 338350  # n (n + 1) (2 n + 1) / 6 for 100


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "nested.py").write_text(LOOPS)
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path


def loops(home: Path) -> Any:
    """The functions as a new process would have them."""
    specification = importlib.util.spec_from_file_location("nested", home / "nested.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def kept(home: Path, mark: str) -> set[str]:
    """The functions of which something is kept."""
    found = (home / "cache").rglob(f"*.{mark}.nbi")
    return {path.name.partition("-")[0].rpartition(".")[2] for path in found}


def test_only_what_python_calls_becomes_machine_code(home: Path) -> None:
    assert loops(home).pyramid(100) == PYRAMID
    assert kept(home, "sealed") == {"pyramid"}
    assert kept(home, "linked") == {"pyramid", "square"}


def test_what_others_call_may_be_called_from_python_too(home: Path) -> None:
    made = loops(home)
    assert made.pyramid(100) == PYRAMID
    assert made.square(12) == 144
    assert kept(home, "sealed") == {"pyramid", "square"}
    again = loops(home)
    assert again.square(12) == 144
    assert again.pyramid(100) == PYRAMID
    assert again.square.stats.cache_hits
    assert again.pyramid.stats.cache_hits


def test_ir_that_was_kept_is_linked_into_a_new_caller(home: Path) -> None:
    """The caller's machine code is gone, as when only its own file has changed."""
    assert loops(home).pyramid(100) == PYRAMID
    for path in (home / "cache").rglob("*pyramid*"):
        path.unlink()
    assert loops(home).pyramid(100) == PYRAMID
    assert kept(home, "sealed") == {"pyramid"}


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
def test_damaged_ir_is_made_anew(suffix: str, home: Path, caplog: pytest.LogCaptureFixture) -> None:
    assert loops(home).pyramid(100) == PYRAMID
    (entry,) = (home / "cache").rglob(f"*square*.linked*.{suffix}")
    entry.write_bytes(entry.read_bytes()[:-1])
    for path in (home / "cache").rglob("*pyramid*"):
        path.unlink()
    assert loops(home).pyramid(100) == PYRAMID
    assert caplog.messages == [f"warning: {entry} was damaged; it is made anew."]


def test_an_exception_of_a_nested_function_reaches_python(home: Path) -> None:
    """From what was just compiled, and from what the next process reads from disk."""
    for from_disk in (False, True):
        made = loops(home)
        assert made.assigned(np.zeros(3), np.ones(2)) == 2.0
        with pytest.raises(ValueError, match="cannot assign slice"):
            made.assigned(np.zeros(3), np.ones(5))
        assert bool(made.assigned.stats.cache_hits) == from_disk


def test_processes_that_need_a_function_at_once_compile_it_once(home: Path) -> None:
    """One of them waits for the other, or comes later; both compute the same."""
    command = "from nested import pyramid; print(pyramid(100), bool(pyramid.stats.cache_hits))"
    both = [
        subprocess.Popen(
            [sys.executable, "-c", command],
            cwd=home, env=environment(NUMBA_CACHE_DIR=str(home / "cache")),
            stdout=subprocess.PIPE, text=True,
        )
        for _ in range(2)
    ]  # fmt: skip
    said = sorted(process.communicate(timeout=300)[0] for process in both)
    assert said == [f"{PYRAMID} False\n", f"{PYRAMID} True\n"]


def test_a_function_that_failed_to_compile_holds_up_nobody(home: Path) -> None:
    made = loops(home)
    with pytest.raises(TypingError):
        made.square("text")
    assert made.square(12) == 144
    assert loops(home).square(12) == 144


def test_with_another_release_of_numba_loops_are_its_own(
    home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They are kept with checksums all the same, and no IR beside them."""
    monkeypatch.setattr(numba, "version_info", numba.version_info._replace(short=(0, 67)))
    other = runpy.run_path(jit.__file__)
    monkeypatch.setattr(jit, "kernel", other["kernel"])
    monkeypatch.setattr(jit, "allocating_kernel", other["allocating_kernel"])
    made = loops(home)
    assert type(made.pyramid) is type(numba.njit(lambda: 0))
    assert made.pyramid(100) == PYRAMID
    assert made.assigned(np.zeros(3), 2.0) == 4.0
    assert kept(home, "linked") == set()
    assert kept(home, "sealed") >= {"pyramid", "assigned"}
