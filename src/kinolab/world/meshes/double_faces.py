"""Triangles that a mesh has twice: copies, and pairs that face both ways.

Programs that draw surfaces from both sides, SketchUp first of all, write every triangle once for
each side. Such a surface says nothing about which side of it is solid.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.world.meshes.mesh_components import components
from kinolab.world.shapes.shape_surfaces import Faces


class SingleFaces(NamedTuple):
    """The triangles of a mesh, each once.

    Attributes:
        rows: Which of the given triangles these are, shape (m,).
        faces: Those of two-sided parts are turned to agree with each other, shape (m, 3).
        both: Whether they belong to parts that faced both ways, shape (m,).
        copies: Triangles that were left out since they repeat another one.
        pairs: Triangles that were left out since they are the back of another one.
    """

    rows: NDArray[np.int64]
    faces: Faces
    both: NDArray[np.bool_]
    copies: int
    pairs: int


def single_faces(vertices: Array, faces: Faces) -> SingleFaces:
    """Keep one of every set of equal triangles, and one of every pair that faces both ways.

    A pair stays where it belongs to a part that encloses space: it is a wall between two chambers.

    Args:
        vertices: Merged, shape (n, 3).
        faces: With three different corners, shape (m, 3).
    """
    rows = np.unique(_from_lowest(faces), axis=0, return_index=True)[1]
    rows = np.sort(rows).astype(np.int64)
    copies, kept = len(faces) - len(rows), faces[rows]
    _, first, which, count = np.unique(
        np.sort(kept, axis=1), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    paired = count[which.reshape(-1)] > 1
    if not paired.any():
        return SingleFaces(rows, kept, paired, copies, 0)
    parts = components(vertices, kept)
    sides = np.bincount(parts.label, weights=paired) / np.bincount(parts.label)
    # of a part's triangles that are there both ways, from which on it is two-sided
    both = ((parts.volume == 0.0) & (sides >= 0.5))[parts.label]
    front = np.zeros(len(kept), dtype=bool)
    front[first] = True
    stays = ~both | front
    single, both = kept[stays], both[stays]
    single[both] = _agreeing(single[both])
    return SingleFaces(rows[stays], single, both, copies, int((~stays).sum()))


def _from_lowest(faces: Faces) -> Faces:
    """Begin every triangle with its lowest vertex; the way round stays."""
    place = (np.arange(3) + faces.argmin(axis=1)[:, None]) % 3
    return np.take_along_axis(faces, place, axis=1)


def _agreeing(faces: Faces) -> Faces:
    """Turn triangles so that those at both sides of an edge face the same side of the surface.

    Each triangle stands for two nodes of a graph, one for each way round; edges join those that
    agree. Where more than two triangles meet, or the surface has one side only, they stay.
    """
    m = len(faces)
    start, end = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    low, high = np.minimum(start, end), np.maximum(start, end)
    order = np.lexsort((high, low))
    _, begins, uses = np.unique(
        low[order] * (faces.max(initial=0) + 1) + high[order], return_index=True, return_counts=True
    )
    one, other = order[begins[uses == 2]], order[begins[uses == 2] + 1]
    turned = (start[one] == start[other]).astype(np.int64)  # both run the same way along the edge
    a, b = one // 3, other // 3
    ends = np.concatenate([a, a + m]), np.concatenate([b + turned * m, b + (1 - turned) * m])
    graph = scipy.sparse.coo_array((np.ones(2 * len(a)), ends), shape=(2 * m, 2 * m))
    label = scipy.sparse.csgraph.connected_components(graph, directed=False)[1]
    flipped = label[m:] < label[:m]
    return np.where(flipped[:, None], faces[:, ::-1], faces)
