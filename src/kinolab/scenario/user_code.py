"""Python code that a user names: run when it is asked for, and answerable for its own failures.

It is code: it may do whatever the user may. Nothing here runs it unasked.
"""

from __future__ import annotations

import hashlib
import importlib
import os
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

from kinolab.dynamics.symbols.slips import SlipError, remedy_for
from kinolab.errors import InputError, KinolabError, Mistake
from kinolab.files import is_file

_texts: dict[Path, bytes] = {}  # of the files that were run: one may be edited during a search


def python_reference(text: str) -> tuple[str, str] | None:
    """Split ``file.py:name`` into the file and the name; None where a text is nothing like it."""
    file, _, name = text.rpartition(":")
    return (file, name) if file.endswith(".py") and name.isidentifier() else None


def run_file(path: Path, where: str) -> ModuleType:
    """Run a user's Python file, once for as long as its text stays the same.

    Args:
        where: What mistakes are reported for.

    Raises:
        InputError: If there is no such file, or it fails.
    """
    if not is_file(path):
        raise InputError([Mistake(where, f"there is no Python file {path}.")])
    place, source = path.resolve(), path.read_bytes()
    _texts[place] = source
    with blamed(f"running {path.name}", where, place):
        return _module(place, source)


def text_of(path: Path) -> bytes:
    """Return the text of a user's file as it was run last, or as it is where it was not run."""
    return _texts.get(path.resolve()) or path.read_bytes()


@cache
def _module(path: Path, source: bytes) -> ModuleType:
    """Run a file as a module under a name that no other file has, nor another text of this one."""
    digest = hashlib.sha256(b"\0".join([os.fsencode(path), source])).hexdigest()
    name = f"kinolab_user_{path.stem}_{digest[:12]}"
    specification = spec_from_file_location(name, path)
    assert specification is not None
    module = module_from_spec(specification)
    sys.modules[name] = module  # dataclasses look their module up while they are made
    try:
        exec(compile(source, str(path), "exec", dont_inherit=True), vars(module))
    except BaseException:
        del sys.modules[name]
        raise
    return module


@contextmanager
def blamed(
    doing: str,
    where: str,
    file: Path | None = None,
    *,
    remedy: str = "",
    passing: tuple[type[Exception], ...] = (KinolabError,),
) -> Iterator[None]:
    """Turn what a user's code raises into a mistake that names the line.

    Args:
        doing: What failed, as in "running own.py".
        where: What the mistake is reported for.
        file: The user's file; where none is given, the one that the error came from is named too.
        remedy: What would work.
        passing: Errors that are left as they are: kinolab's say already what is wrong with a
            machine, but not which line of a search brought them about.

    Raises:
        InputError: For everything else, but for a lack of memory.
    """
    own = (MemoryError, KeyboardInterrupt, GeneratorExit)
    kept: tuple[type[BaseException], ...] = (*own, *passing)
    try:
        yield
    except SlipError as error:
        place = _place(error, file)
        raise InputError(replace(m, where=f"{m.where}{place}") for m in error.mistakes) from error
    except kept:
        raise
    except BaseException as error:
        words = " ".join(f"{type(error).__name__}: {error}".split())
        what = f"{doing} failed{_place(error, file)} ({words})."
        raise InputError([Mistake(where, what, remedy_for(error) or remedy)]) from error


def _place(error: BaseException, file: Path | None) -> str:
    """Return " on line 3", or " on line 3 of other.py"; nothing where no line is to blame."""
    frames = traceback.extract_tb(error.__traceback__)
    lines = [(Path(frame.filename), frame.lineno) for frame in frames]
    if isinstance(error, SyntaxError) and error.filename:
        lines.append((Path(error.filename), error.lineno))
    lines = [at for at in lines if (at[0] == file if file is not None else _is_a_users(at[0]))]
    if not lines:
        return ""
    path, line = lines[-1]
    return f" on line {line}" if file is not None else f" on line {line} of {path.name}"


def _is_a_users(path: Path) -> bool:
    """Whether a line of code is neither kinolab's nor Python's machinery of imports."""
    machinery = (Path(__file__).parents[1], Path(str(importlib.__file__)).parent)
    backport = "importlib_metadata" in path.parts  # of libraries for older versions of Python
    return not (backport or str(path).startswith("<") or any(map(path.is_relative_to, machinery)))
