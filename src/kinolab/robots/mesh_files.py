"""Where the mesh files of a robot are."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from urllib.parse import unquote

PACKAGE, FILE = "package://", "file://"


def find_mesh(name: str, folder: Path, packages: Mapping[str, str | Path]) -> Path | None:
    """Return the file that a robot's description names, None where it is not there.

    Packages that are not given are looked for in the folders above the description: there one has
    the package's name, or holds what the package would.

    Args:
        name: ``package://package/path``, ``file://path``, or a path from the description's folder.
        folder: Of the description.
        packages: Folders by the name of the package.
    """
    if not name.startswith(PACKAGE):
        found = folder / unquote(name.removeprefix(FILE))
        return found if found.is_file() else None
    package, _, rest = unquote(name.removeprefix(PACKAGE)).partition("/")
    if package in packages:
        found = Path(packages[package]) / rest
        return found if found.is_file() else None
    for above in (folder.resolve(), *folder.resolve().parents):
        for found in (above / package / rest, above / rest):
            if (above.name == package or found.parts[-1]) and found.is_file():
                return found
    return None
