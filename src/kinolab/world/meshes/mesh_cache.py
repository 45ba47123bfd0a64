"""Meshes on disk as they were read and checked, by the content of their files.

An entry takes about 50 bytes per triangle; those that were used last stay.
"""

from __future__ import annotations

import hashlib
import math
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.cache import code_in, folder
from kinolab.files import discard, keep_last_used, read_sealed, touch, write_sealed
from kinolab.numerics.arrays import Array
from kinolab.world.shape_surfaces import Faces

MAGIC = b"kinolab mesh 2\n"
MAX_BYTES = 2**28  # [bytes] of all entries
HEADER = np.dtype("<i8")


class Mesh(NamedTuple):
    """Triangles as a file gives them, in the file's units, duplicates merged."""

    vertices: Array  # (n, 3)
    faces: Faces  # (m, 3)
    label: NDArray[np.int64]  # (m,) the connected part that each face belongs to
    both: NDArray[np.bool_]  # (m,) whether it belongs to a part whose faces look both ways
    colors: NDArray[np.uint8]  # (m, 3) red, green, blue; (0, 3) of a file without colours
    repeated: NDArray[np.int64]  # (2,) triangles left out as copies, and as backs of others
    declared: Array  # (2,) unit in [m], 0 if not said; axis that points up, -1 if not said


def entry_for(kind: str, content: bytes, materials: bytes = b"") -> Path:
    """Return where a mesh is kept, by the format and content of its file and its materials."""
    parts = (kind.encode(), _own_code().encode(), hashlib.sha256(materials).digest(), content)
    return folder() / f"{hashlib.sha256(bytes(1).join(parts)).hexdigest()}.mesh"


def read_mesh(path: Path) -> Mesh | None:
    """Return a mesh that was kept, None where there is none or it is damaged."""
    content = read_sealed(path, MAGIC)
    if content is None:
        return None
    touch(path)
    try:
        return _unpacked(content)
    except ValueError:
        discard(path, "was damaged")
        return None


def _unpacked(content: memoryview) -> Mesh:
    """Return the mesh of an entry.

    Raises:
        ValueError: If the entry is shorter or longer than it says.
    """
    n, m, painted = np.frombuffer(content, HEADER, 3).tolist()
    layout = _layout(n, m, painted)
    at, parts = 3 * HEADER.itemsize, []
    size = at + sum(math.prod(shape) * np.dtype(dtype).itemsize for dtype, shape in layout)
    if min(n, m, painted) < 0 or size != len(content):
        raise ValueError("it is not as large as it says")
    for dtype, shape in layout:
        part = np.frombuffer(content, dtype, math.prod(shape), at).reshape(shape)
        parts.append(part.copy())  # aligned
        at += part.nbytes
    mesh = Mesh(*parts)
    if not m or mesh.faces.min() < 0 or mesh.faces.max() >= n:
        raise ValueError("it has a vertex that does not exist")
    return mesh


def keep_mesh(path: Path, mesh: Mesh) -> None:
    """Write a mesh, and remove those unused for longest where all take too much."""
    head = np.array([len(mesh.vertices), len(mesh.faces), len(mesh.colors)], HEADER)
    write_sealed(path, MAGIC, b"".join(part.tobytes() for part in (head, *mesh)))
    keep_last_used(path, MAX_BYTES)


def _layout(n: int, m: int, painted: int) -> list[tuple[type[np.generic], tuple[int, ...]]]:
    """Return the type and shape of each field of ``Mesh``, in its order."""
    return [
        (np.float64, (n, 3)),
        (np.int64, (m, 3)),
        (np.int64, (m,)),
        (np.bool_, (m,)),
        (np.uint8, (painted, 3)),
        (np.int64, (2,)),
        (np.float64, (2,)),
    ]


@cache
def _own_code() -> str:
    return code_in(Path(__file__).parents[1])
