"""Meshes on disk as they were read and checked, by the content of their files.

An entry takes 48 bytes per triangle; those that were used last stay.
"""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.cache import code_in, folder
from kinolab.files import keep_last_used, read_sealed, touch, write_sealed
from kinolab.numerics.arrays import Array
from kinolab.world.shape_surfaces import Faces

MAGIC = b"kinolab mesh 1\n"
MAX_BYTES = 2**28  # [bytes] of all entries
HEADER = np.dtype("<i8")


class Mesh(NamedTuple):
    """Triangles as a file gives them, in the file's units, duplicate vertices merged."""

    vertices: Array  # (n, 3)
    faces: Faces  # (m, 3)
    label: NDArray[np.int64]  # (m,) the connected part that each face belongs to


def entry_for(kind: str, content: bytes) -> Path:
    """Return where a mesh is kept, by the format and content of its file."""
    parts = (kind.encode(), _own_code().encode(), content)
    return folder() / f"{hashlib.sha256(bytes(1).join(parts)).hexdigest()}.mesh"


def read_mesh(path: Path) -> Mesh | None:
    """Return a mesh that was kept, None where there is none or it is damaged."""
    content = read_sealed(path, MAGIC)
    if content is None:
        return None
    touch(path)
    n, m = np.frombuffer(content, HEADER, 2).tolist()
    at = 2 * HEADER.itemsize
    vertices = np.frombuffer(content, np.float64, 3 * n, at).reshape(n, 3).copy()  # aligned
    numbers = np.frombuffer(content, np.int64, 4 * m, at + vertices.nbytes)
    return Mesh(vertices, numbers[: 3 * m].reshape(m, 3).copy(), numbers[3 * m :].copy())


def keep_mesh(path: Path, mesh: Mesh) -> None:
    """Write a mesh, and remove those unused for longest where all take too much."""
    head = np.array([len(mesh.vertices), len(mesh.faces)], HEADER)
    write_sealed(path, MAGIC, b"".join(part.tobytes() for part in (head, *mesh)))
    keep_last_used(path, MAX_BYTES)


@cache
def _own_code() -> str:
    return code_in(Path(__file__).parent)
