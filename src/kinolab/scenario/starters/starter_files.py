"""A machine and a scenario to start from, written as files."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from kinolab.errors import InputError, Mistake

STARTERS = ("puck", "wheels", "arm", "flyer", "segway", "pick-and-place", "hopper")


def write_starter(name: str, folder: Path, kind: str = "puck") -> list[Path]:
    """Write NAME.py and NAME.toml and return their paths.

    Args:
        folder: Where they go.
        kind: Of the machine: one of ``STARTERS``.

    Raises:
        InputError: If the name cannot be a function's, or a file exists already.
    """
    if not name.isidentifier():
        remedy = "Use letters, digits and underscores, beginning with a letter."
        raise InputError([Mistake(repr(name), "this cannot be the name of a machine.", remedy)])
    written = {folder / f"{name}.{ending}": ending for ending in ("py", "toml")}
    existing = [
        Mistake(str(path), "this file exists already.", "Choose another name.")
        for path in written
        if path.exists()
    ]
    if existing:
        raise InputError(existing)
    for path, ending in written.items():
        path.write_text(_text(kind, ending).replace("{name}", name), encoding="utf-8")
    return list(written)


def _text(kind: str, ending: str) -> str:
    """Return a text of this folder; below the heading of wheels comes ``diff_drive``."""
    name = f"{kind.replace('-', '_')}.{'txt' if ending == 'py' else ending}"
    text = files(__package__).joinpath(name).read_text(encoding="utf-8")
    if name == "wheels.txt":
        source = files("kinolab.systems").joinpath("diff_drive.py").read_text(encoding="utf-8")
        text += source.partition("\n")[2].replace("diff_drive", "{name}")
    return text
