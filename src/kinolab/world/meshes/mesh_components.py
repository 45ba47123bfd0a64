"""Which parts of a mesh enclose space, and on which side of them the solid lies."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.world.shapes.shape_surfaces import Faces


class Components(NamedTuple):
    """The connected parts of a mesh.

    A closed part with outward faces (a solid) has a positive volume, one with inward faces (a
    room, a cavity) a negative one. A part that is not closed has volume 0.
    """

    label: NDArray[np.int64]  # (m,) the part of each face
    volume: Array  # (parts,) signed, [m³]


def components(vertices: Array, faces: Faces, label: NDArray[np.int64] | None = None) -> Components:
    """Split a mesh into its connected parts.

    Args:
        vertices: Merged, shape (n, 3).
        faces: Shape (m, 3).
        label: The part of each face, shape (m,), where it is known.
    """
    if label is None:
        label = connected_parts(len(vertices), faces)
    a, b, c = (vertices[faces[:, k]] - vertices.mean(axis=0) for k in range(3))
    cones = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    volume = np.bincount(label, weights=cones).astype(np.float64)
    volume[np.unique(label[_has_open_edge(len(vertices), faces)])] = 0.0
    # volumes below this share of the cubed extent are sheets folded onto themselves
    volume[np.abs(volume) < 1e-12 * np.ptp(vertices, axis=0).max() ** 3] = 0.0
    return Components(label, volume)


def connected_parts(count: int, faces: Faces) -> NDArray[np.int64]:
    """Number the parts of a mesh of ``count`` vertices: the part of each face, shape (m,)."""
    ends = np.concatenate([faces[:, :2], faces[:, 1:]])
    graph = scipy.sparse.coo_array(
        (np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count)
    )
    part_of_vertex = scipy.sparse.csgraph.connected_components(graph, directed=False)[1]
    return np.unique(part_of_vertex[faces[:, 0]], return_inverse=True)[1].astype(np.int64)


def _has_open_edge(count: int, faces: Faces) -> NDArray[np.bool_]:
    """Mark faces at an edge that is not run through as often in one direction as in the other.

    Balanced edges are what a winding number needs. This admits two boxes that share an edge, which
    mazes are full of and where four faces meet.
    """
    start, end = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    edge = np.minimum(start, end) * count + np.maximum(start, end)
    _, which = np.unique(edge, return_inverse=True)
    balance = np.bincount(which, weights=np.where(start < end, 1.0, -1.0))
    open_edge: NDArray[np.bool_] = (balance[which] != 0.0).reshape(-1, 3).any(axis=1)
    return open_edge
