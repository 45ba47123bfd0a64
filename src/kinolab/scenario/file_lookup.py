"""Where a file of the user's is, and its text."""

from __future__ import annotations

import importlib.resources
import os
from pathlib import Path

from kinolab.errors import InputError, Mistake, meant, printable
from kinolab.scenario.toml_text import shortened
from kinolab.untrusted import read

ENDINGS = (".toml", ".yaml", ".yml", ".cfg")  # of paths, with or without a folder before them


def builtin_scenarios() -> dict[str, Path]:
    """The scenarios that come with kinolab, by name; none where they are not installed."""
    try:
        entries = list(importlib.resources.files("kinolab.scenarios").iterdir())
    except (ModuleNotFoundError, FileNotFoundError):
        return {}
    files = [entry for entry in entries if isinstance(entry, Path) and entry.suffix == ".toml"]
    # an editable installation links each file, and meshes lie beside the scenario itself
    return {file.stem: file.resolve() for file in sorted(files)}


def scenario_path(source: str | Path) -> Path:
    """Return the file that a path or the name of a built-in scenario means."""
    separators = {"/", os.sep, os.altsep or "/"}
    named = isinstance(source, str) and not source.endswith(ENDINGS)
    if named and not separators.intersection(str(source)):
        return builtin_scenarios().get(str(source), Path(source))
    return Path(source)


def read_text(path: Path) -> str:
    """Read a file of at most 30 MB as UTF-8, with or without a byte order mark.

    Raises:
        InputError: If there is no such file, or it is none of this kind.
    """
    where = shortened(printable(str(path)), 200)
    if not os.path.isfile(path):  # unlike pathlib's, it never raises
        raise InputError([_no_file(path, where)])
    content = read(path, "scenario", where, "Keep meshes in files of their own.")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        what, remedy = "this is not UTF-8 text.", "Save the file as UTF-8."
        raise InputError([Mistake(f"{path.name} line {line}", what, remedy)]) from None


def _no_file(path: Path, where: str) -> Mistake:
    if os.path.isdir(path):
        inside = sorted(file.name for file in path.glob("*.toml"))[:10]
        remedy = f"In it: {', '.join(inside)}." if inside else "Give the .toml file."
        return Mistake(where, "this is a folder, not a scenario.", remedy)
    if os.path.exists(path):
        return Mistake(where, "this is not an ordinary file.", "Give a .toml file.")
    what = f"there is no file {shortened(printable(os.path.abspath(path)), 400)}."
    if path.parent != Path(".") or path.suffix in ENDINGS:
        return Mistake(where, what, meant(path.stem, _neighbours(path)))
    return Mistake(
        where,
        f"no scenario is called {shortened(path.name)!r}, and {what}",
        f"{meant(path.name, [*builtin_scenarios(), *_neighbours(path)])} "
        f"Built in: {', '.join(builtin_scenarios()) or 'none'}.".lstrip(),
    )


def _neighbours(path: Path) -> list[str]:
    endings = (path.suffix,) if path.suffix in ENDINGS else ENDINGS
    if not os.path.isdir(path.parent):
        return []
    return sorted(file.name for end in endings for file in path.parent.glob(f"*{end}"))
