"""The Python file of a scenario's machine, where it has one of its own."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from kinolab import systems
from kinolab.errors import InputError, Mistake
from kinolab.files import read_ordinary, utf_8, write_whole
from kinolab.scenario.user_code import python_reference
from kinolab.studio.core.chosen_folder import SIZE_LIMIT, ChosenFolder
from kinolab.studio.core.scenario_text import Change, Drop, Put


def machine_file(folder: ChosenFolder, values: Mapping[str, Any]) -> Path | None:
    """Return the Python file that a scenario names, which may be missing; None if it names none.

    Raises:
        InputError: If it is outside of the folder.
    """
    name = _said(values, "file")
    reference = python_reference(name)
    name = reference[0] if reference else name
    return folder.path(name) if name.endswith(".py") else None


def registered_name(values: Mapping[str, Any]) -> str:
    """Return the name of the registered machine that a scenario takes; empty if it takes none."""
    return _said(values, "name")


def _said(values: Mapping[str, Any], key: str) -> str:
    section = values.get("system", {})
    return str(section.get(key, "")) if isinstance(section, dict) else ""


def read_machine(path: Path) -> str:
    """Return the text of a machine's file; empty where there is none.

    Raises:
        InputError: If it is too large, or not text.
    """
    if not path.exists():
        return ""
    try:
        return read_ordinary(path, SIZE_LIMIT).decode("utf-8").replace("\r\n", "\n")
    except UnicodeDecodeError:
        what = "this is not text in UTF-8."
        raise InputError([Mistake(path.name, what, "Save it as UTF-8.")]) from None


def write_machine(path: Path, text: str) -> None:
    """Write the text of a machine's file."""
    write_whole(path, utf_8(text if text.endswith("\n") else f"{text}\n"))


def own_copy(folder: ChosenFolder, name: str) -> list[Change]:
    """Copy the file that describes a registered machine, and have a scenario take the copy.

    Args:
        folder: Where the copy goes.

    Raises:
        InputError: If there is a file of this name already.
    """
    place = folder.path(f"{name}.py")
    if place.exists():
        what, remedy = "this file exists already.", "Rename it, or name it in the text, under File."
        raise InputError([Mistake(place.name, what, remedy)])
    write_machine(place, Path(inspect.getfile(systems.maker(name))).read_text(encoding="utf-8"))
    return [Drop(("system", "name")), Put(("system", "file"), f"{place.name}:{name}")]
