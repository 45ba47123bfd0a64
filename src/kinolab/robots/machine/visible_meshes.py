"""What is seen of a robot: its meshes with few triangles, one for every colour."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from kinolab.dynamics.language.shapes import DrawnMesh
from kinolab.errors import InputError, printable
from kinolab.files import LOG
from kinolab.numerics.arrays import Array
from kinolab.robots.tree.kinematic_tree import KinematicTree, VisibleMesh
from kinolab.world.mesh_simplification import fewer_triangles
from kinolab.world.shapes.shape_surfaces import Faces


def drawn_meshes(tree: KinematicTree) -> Mapping[str, tuple[DrawnMesh, ...]]:
    """Return what is drawn of links, by their names; those without meshes are left out.

    Larger meshes lose triangles; where they cannot, none is drawn, and a warning says so.
    """
    most = _most([len(mesh.faces) for link in tree.links for mesh in link.visible])
    try:
        return {
            link.name: tuple(made for mesh in link.visible for made in _drawn(mesh, most))
            for link in tree.links
            if link.visible
        }
    except InputError as error:
        LOG.warning("%s: its meshes are not drawn: %s", printable(tree.name), error)
        return {}


def _most(sizes: Sequence[int]) -> float:
    """Return how many triangles every mesh may keep, so that small ones keep all."""
    left = 30_000.0  # of a robot: half a megabyte of every run
    for k, size in enumerate(sorted(sizes)):
        most = left / (len(sizes) - k)
        if size > most:
            return most
        left -= size
    return math.inf


def _drawn(mesh: VisibleMesh, most: float) -> Iterator[DrawnMesh]:
    share = min(1.0, most / len(mesh.faces))
    for color, faces in _by_color(mesh):
        used, corners = np.unique(faces, return_inverse=True)
        vertices, triangles = mesh.vertices[used], corners.reshape(-1, 3)
        count = max(12, int(share * len(faces)))  # triangles that are left of a mesh
        if share < 1.0 and count < len(faces):
            vertices, triangles = fewer_triangles(mesh.name, vertices, triangles, count)
        yield DrawnMesh.of(vertices, triangles, color)


def _by_color(mesh: VisibleMesh) -> Iterator[tuple[tuple[float, float, float], Faces]]:
    """Yield the colours of a mesh with their faces, rare ones with the frequent one nearest."""
    if mesh.colors is None:
        yield (0.9, 0.9, 0.92), mesh.faces  # of what has no colour
        return
    colors, which, counts = np.unique(mesh.colors, axis=0, return_inverse=True, return_counts=True)
    kept = np.argsort(-counts, kind="stable")[:8]  # of one mesh
    apart: Array = np.linalg.norm(colors[:, None] - colors[kept][None], axis=2)
    nearest = apart.argmin(axis=1)[which.reshape(-1)]
    for k, color in enumerate(colors[kept]):
        red, green, blue = color.round(4).tolist()
        yield (red, green, blue), mesh.faces[nearest == k]
