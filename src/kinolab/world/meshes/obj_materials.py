"""The file of materials that an OBJ names: looked up beside it, and never outside one folder."""

from __future__ import annotations

import re
from pathlib import Path

from kinolab.untrusted import BYTES

NAMED = re.compile(rb"^[ \t]*+mtllib[ \t]++(\S[^\r\n]*+)", re.MULTILINE)
SUFFIX = ".mtl"


class Materials:
    """Gives trimesh the one file of materials that was read, and no texture.

    Args:
        content: Of that file; empty where there is none.
    """

    def __init__(self, content: bytes) -> None:
        self._content = content

    def get(self, name: str) -> bytes:
        """Return the materials for any name of such a file.

        Raises:
            OSError: If there are none, or something else is asked for.
        """
        if not self._content or not name.lower().endswith(SUFFIX):
            raise OSError(f"{name} is not read.")
        return self._content

    __getitem__ = get


def materials_file(mesh: Path, content: bytes, root: Path) -> Path | None:
    """Return the first file of materials that an OBJ names, None where it cannot be read.

    A missing one is no mistake: meshes are often passed on without.

    Args:
        root: The folder that the file of materials must be in, or below.
    """
    named = NAMED.search(content) if mesh.suffix.lower() == ".obj" else None
    if named is None:
        return None
    name = named[1].rstrip(b" \t").decode(errors="replace").replace("\\", "/")
    try:
        file = (mesh.parent / name).resolve()
        usable = file.suffix.lower() == SUFFIX and file.is_relative_to(root.resolve())
        small = usable and file.is_file() and file.stat().st_size <= BYTES["materials"]
        return file if small else None
    except (OSError, ValueError, RuntimeError):
        return None


def with_materials(content: bytes, name: str) -> bytes:
    """Return an OBJ that names another file of materials."""
    return NAMED.sub(b"mtllib " + name.encode().replace(b"\\", b"\\\\"), content, count=1)
