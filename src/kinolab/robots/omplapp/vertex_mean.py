"""The mean of a mesh's vertices as assimp has them, which OMPL.app takes for a robot's centre.

It depends on how often a place counts: once for each normal and texture that triangles have there.

Source: assimp 5.4, code/PostProcessing/JoinVerticesProcess.cpp.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator, Sequence

import numpy as np

from kinolab.lazy import library_of
from kinolab.numerics.arrays import Array


def mean_of_triangles(triangles: Array) -> Array:
    """Return the mean (3,) of the corners of triangles (n, 3, 3) that give no normals."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    corners = _distinct(triangles.reshape(-1, 3), [np.repeat(normals, 3, axis=0)])
    return np.asarray(corners.mean(axis=0))


def mean_in_collada(content: bytes) -> Array:
    """Return the mean (3,) of the vertices in a COLLADA file that was read as a mesh before.

    Args:
        content: Of the file; the mean is in its unit and axes.
    """
    collada = library_of("collada", "collada", "DAE files are read by pycollada")
    kind = collada.triangleset.BoundTriangleSet
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = collada.Collada(io.BytesIO(content), ignore=[collada.common.DaeError])
        parts = [
            part.triangleset() if hasattr(part, "triangleset") else part
            for geometry in file.scene.objects("geometry")
            for part in geometry.primitives()
        ]
        places = [
            _distinct(part.vertex[part.vertex_index.reshape(-1)], [*_looks(part)])
            for part in parts
            if isinstance(part, kind) and part.vertex is not None and len(part.vertex_index)
        ]
    mean: Array = np.concatenate(places).mean(axis=0)
    return mean


def _looks(part: object) -> Iterator[Array]:
    """Yield normals and textures of a part's corners, shapes (n, 3) and (n, 2)."""
    if part.normal is not None:  # type: ignore[attr-defined]
        yield part.normal[part.normal_index.reshape(-1)]  # type: ignore[attr-defined]
    sets = zip(part.texcoordset, part.texcoord_indexset, strict=True)  # type: ignore[attr-defined]
    for texture, index in sets:
        yield texture[index.reshape(-1)]


def _distinct(places: Array, looks: Sequence[Array]) -> Array:
    """Return the places (n, 3) of corners that differ in place or look."""
    # 1e-6 of the size of a part: places that are one but for rounding
    least = 1e-6 * float(np.linalg.norm(np.ptp(places, axis=0))) or 1.0
    # 1e-5 of normals and textures that are one to assimp
    rows = np.hstack([places / least, *(look / 1e-5 for look in looks)])
    return np.asarray(places, dtype=np.float64)[
        np.unique(np.round(rows), axis=0, return_index=True)[1]
    ]
