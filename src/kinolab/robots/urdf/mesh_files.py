"""Where the mesh files of a robot are."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from urllib.parse import unquote

from kinolab.files import is_file

PACKAGE, FILE = "package://", "file://"


def find_mesh(name: str, folder: Path, packages: Mapping[str, str | Path]) -> Path | None:
    """Return the file that a robot's description names, None where it is not there.

    Packages that are not given are looked for in the folders above the description, from there the
    whole path and its ends of two parts at least, since packages are often copied in parts.

    Args:
        name: ``package://package/path``, ``file://path``, or a path from the description's folder.
        folder: Of the description.
        packages: Folders by the name of the package.
    """
    if not name.startswith(PACKAGE):
        found = folder / unquote(name.removeprefix(FILE))
        return found if is_file(found) else None
    package, _, rest = unquote(name.removeprefix(PACKAGE)).partition("/")
    if package in packages:
        found = Path(packages[package]) / rest
        return found if is_file(found) else None
    parts = (package, *Path(rest).parts)
    ends = [Path(*parts[k:]) for k in range(len(parts) - 1)]
    for above in (folder.resolve(), *folder.resolve().parents):
        for end in ends:
            if is_file(above / end):
                return above / end
    return None
