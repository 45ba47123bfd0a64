"""Coloured meshes as page data: faces sorted by colour, and crease edges."""

from __future__ import annotations

from typing import Any

import numpy as np

from kinolab.show.film.models.surface_mesh import Indices, SurfaceMesh
from kinolab.show.page.pack import Pack

KEYS = np.array([1 << 32, 1 << 16, 1])  # colours of four decimals as numbers, in the same order


def by_color(mesh: SurfaceMesh) -> tuple[Indices, list[tuple[list[float], int, int]]]:
    """Return the faces sorted by colour, and (red, green, blue), first face, number of faces."""
    rounded = mesh.colors.round(4)
    keys = np.rint(1e4 * rounded).astype(np.int64) @ KEYS  # as rows they take ten times as long
    _, one, which, counts = np.unique(
        keys, return_index=True, return_inverse=True, return_counts=True
    )
    colors = rounded[one]
    first = np.concatenate([[0], np.cumsum(counts)])
    groups = [(color.tolist(), int(first[k]), int(counts[k])) for k, color in enumerate(colors)]
    return mesh.faces[np.argsort(which, kind="stable")], groups


def mesh_data(mesh: SurfaceMesh, pack: Pack) -> dict[str, Any]:
    """Return a mesh as the page's ``meshes.js`` reads it."""
    faces, groups = by_color(mesh)
    return {
        "vertices": pack.add(mesh.vertices, "f4"),
        "faces": pack.indices(faces),
        "edges": pack.indices(mesh.ends[mesh.creases]),
        "colors": [{"rgb": rgb, "first": first, "count": count} for rgb, first, count in groups],
    }
