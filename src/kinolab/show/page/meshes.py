"""Coloured meshes as page data: faces sorted by colour, and crease edges."""

from __future__ import annotations

from typing import Any

from kinolab.show.page.pack import Pack
from kinolab.show.scene.models.surface_mesh import SurfaceMesh, by_color


def mesh_data(mesh: SurfaceMesh, pack: Pack) -> dict[str, Any]:
    """Return a mesh as the page's ``meshes.js`` reads it."""
    faces, groups = by_color(mesh)
    return {
        "vertices": pack.add(mesh.vertices, "f4"),
        "faces": pack.indices(faces),
        "edges": pack.indices(mesh.ends[mesh.creases]),
        "colors": [{"rgb": rgb, "first": first, "count": count} for rgb, first, count in groups],
    }
