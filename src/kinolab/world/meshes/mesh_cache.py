"""Meshes on disk as they were read and checked, by the content of their files.

An entry takes about 50 bytes per triangle; those that were used last stay.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.store import Kind, pack_arrays, unpack_arrays
from kinolab.world.shapes.shape_surfaces import Faces


class Mesh(NamedTuple):
    """Triangles as a file gives them, in the file's units, duplicates merged."""

    vertices: Array  # (n, 3)
    faces: Faces  # (m, 3)
    label: NDArray[np.int64]  # (m,) the connected part that each face belongs to
    both: NDArray[np.bool_]  # (m,) whether it belongs to a part whose faces look both ways
    colors: NDArray[np.uint8]  # (m, 3) red, green, blue; (0, 3) of a file without colours
    repeated: NDArray[np.int64]  # (2,) triangles left out as copies, and as backs of others
    declared: Array  # (2,) unit in [m], 0 if not said; axis that points up, -1 if not said


def _unpack(content: memoryview) -> Mesh:
    mesh = Mesh(*unpack_arrays(content, *DTYPES))
    shapes = [part.shape[1:] for part in mesh]
    if shapes != [(3,), (3,), (), (), (3,), (), ()] or not len(mesh.faces):
        raise ValueError("it is not a mesh")
    if mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.vertices):
        raise ValueError("it has a vertex that does not exist")
    return mesh


DTYPES = (np.float64, np.int64, np.int64, np.bool_, np.uint8, np.int64, np.float64)
MESHES = Kind("mesh", pack_arrays, _unpack, (Path(__file__).parents[1],), most=2**28)
