"""Triangle meshes with a colour per face and crease edges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.numerics.arrays import Array

Indices: TypeAlias = NDArray[np.int64]

# A mesh of so many faces may be a scan. It is one if this fraction of its creases has the same
# smooth piece on both sides, or a piece of one face, as noise has; then the creases that part
# larger pieces are drawn, which are wider than this fraction of the mesh's diagonal.
MANY, ROUGH, SPECK = 2000, 1 / 3, 0.01
KEYS = np.array([1 << 32, 1 << 16, 1])  # colours of four decimals as numbers, in the same order


@dataclass(frozen=True, eq=False)
class SurfaceMesh:
    """A coloured triangle mesh.

    Args:
        vertices: Points in [m], shape (n, 3); of a mesh at nf poses at once (nf, n, 3).
        faces: Three vertices each, shape (m, 3).
        colors: RGB in 0..1 per face, shape (m, 3).
        ends: The two vertices of each edge, shape (e, 2).
        sides: The two faces of each edge, shape (e, 2); a border repeats its one face.
        creases: Whether the surface folds or ends at the edge, shape (e,).
    """

    vertices: Array
    faces: Indices
    colors: Array
    ends: Indices
    sides: Indices
    creases: NDArray[np.bool_]

    @property
    def is_closed(self) -> bool:
        """Whether every edge has a face on both of its sides."""
        return bool((self.sides[:, 0] != self.sides[:, 1]).all())

    @cached_property
    def normals(self) -> Array:
        """The faces' unit normals, shape (m, 3), or (nf, m, 3)."""
        return normals(self.vertices, self.faces)

    def moved(self, pose: ArrayLike) -> SurfaceMesh:
        """The mesh at a pose [R | p], 12 numbers in row-major order."""
        g = np.asarray(pose, dtype=np.float64).reshape(3, 4)
        return replace(self, vertices=self.vertices @ g[:, :3].T + g[:, 3])

    def only(self, faces: NDArray[np.bool_]) -> SurfaceMesh:
        """Some of the faces, and the edges that end at one of them."""
        place = np.cumsum(faces) - 1
        left, right = self.sides[:, 0], self.sides[:, 1]
        kept = faces[left] | faces[right]
        a = np.where(faces[left], left, right)[kept]
        b = np.where(faces[right], right, left)[kept]
        return replace(
            self,
            faces=self.faces[faces],
            colors=self.colors[faces],
            ends=self.ends[kept],
            sides=np.stack([place[a], place[b]], axis=1),
            creases=self.creases[kept] | (a == b),
        )

    def painted(self, color: ArrayLike) -> SurfaceMesh:
        """The mesh in one colour, RGB in 0..1, or in one per face, shape (m, 3)."""
        return replace(self, colors=np.broadcast_to(np.asarray(color, float), self.colors.shape))


def weld(vertices: ArrayLike, faces: ArrayLike, colors: ArrayLike) -> SurfaceMesh:
    """Make a mesh with equal points merged to one vertex, so that faces share edges.

    ``colors`` are RGB in 0..1, shape (3,), or one per face, shape (m, 3).
    """
    points = np.asarray(vertices, dtype=np.float64).reshape(-1, 3)
    merged, where = np.unique(points.round(9), axis=0, return_inverse=True)
    welded = where.reshape(-1)[np.asarray(faces, dtype=np.int64).reshape(-1, 3)]
    painted = np.broadcast_to(np.asarray(colors, dtype=np.float64), welded.shape)
    solid = (welded != np.roll(welded, 1, axis=1)).all(axis=1)
    welded, painted = welded[solid], painted[solid]
    return SurfaceMesh(merged, welded, painted, *_edges(merged, welded))


def join(meshes: Sequence[SurfaceMesh]) -> SurfaceMesh:
    """Several meshes as one; each keeps its own vertices and edges."""
    n = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    m = np.cumsum([0, *(len(mesh.faces) for mesh in meshes)])
    return SurfaceMesh(
        np.concatenate([np.zeros((0, 3)), *(mesh.vertices for mesh in meshes)]),
        _stack([mesh.faces + n[i] for i, mesh in enumerate(meshes)], 3),
        np.concatenate([np.zeros((0, 3)), *(mesh.colors for mesh in meshes)]),
        _stack([mesh.ends + n[i] for i, mesh in enumerate(meshes)], 2),
        _stack([mesh.sides + m[i] for i, mesh in enumerate(meshes)], 2),
        np.concatenate([np.zeros(0, dtype=bool), *(mesh.creases for mesh in meshes)]),
    )


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


def normals(vertices: Array, faces: Indices) -> Array:
    """Unit normals by the right-hand rule, shape (..., m, 3); zero for faces without area."""
    a, b, c = (vertices[..., faces[:, i], :] for i in range(3))
    cross = np.cross(b - a, c - a)
    length = np.linalg.norm(cross, axis=-1, keepdims=True)
    return cross / np.where(length > 0.0, length, 1.0)


def flat_patches(mesh: SurfaceMesh) -> tuple[Indices, Array]:
    """Number the level pieces of a surface: one per face, shape (m,), and their areas in [m^2]."""
    a, b = mesh.sides.T
    # 1 degree at most between faces of one level piece
    level = np.sum(mesh.normals[a] * mesh.normals[b], axis=1) > np.cos(np.radians(1.0))
    patch = joined(len(mesh.faces), mesh.sides[level])
    return patch, np.bincount(patch, areas_of(mesh.vertices, mesh.faces)).astype(np.float64)


def joined(count: int, pairs: Indices) -> Indices:
    """Number what pairs (n, 2) of so many faces join, directly or through others: one per face."""
    from scipy.sparse import coo_array  # late: few films need it
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (count, count))
    return np.asarray(connected_components(graph)[1], dtype=np.int64)


def areas_of(vertices: Array, faces: Indices) -> Array:
    """The areas in [m^2] of faces (m, 3) with these vertices, shape (m,)."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))


def is_room(mesh: SurfaceMesh) -> bool:
    """Whether a closed mesh has inward normals (negative volume), like a room."""
    centred = mesh.vertices - mesh.vertices.mean(axis=0)
    a, b, c = (centred[mesh.faces[:, i]] for i in range(3))
    return bool(mesh.is_closed and np.sum(a * np.cross(b, c)) < 0.0)


def _edges(vertices: Array, faces: Indices) -> tuple[Indices, Indices, NDArray[np.bool_]]:
    halves = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    count = max(len(vertices), 1)
    keys, where, uses = np.unique(
        halves[:, 0] * count + halves[:, 1], return_inverse=True, return_counts=True
    )
    face = (np.argsort(where, kind="stable") // 3).astype(np.int64)
    last = np.cumsum(uses)
    sides = np.stack([face[last - uses], face[last - 1]], axis=1)
    direction = normals(vertices, faces)
    bend = np.sum(direction[sides[:, 0]] * direction[sides[:, 1]], axis=1)
    # Edges below 35 degrees belong to a curved surface and are not drawn.
    border, folded = uses != 2, bend < np.cos(np.radians(35.0))
    if len(faces) > MANY and (folded & ~border).any():
        folded = _without_noise(vertices, faces, sides, folded & ~border)
    return np.stack(np.divmod(keys, count), axis=1), sides, border | folded


def _without_noise(
    vertices: Array, faces: Indices, sides: Indices, folded: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return which of a scan's folded edges are of its form; all of them of what is no scan."""
    piece = joined(len(faces), sides[~folded])
    left, right = piece[sides].T
    alone = np.bincount(piece)[piece] == 1
    noise = folded & ((left == right) | alone[sides].any(axis=1))
    if np.count_nonzero(noise) <= ROUGH * np.count_nonzero(folded):
        return folded
    width = np.sqrt(np.bincount(piece, areas_of(vertices, faces)))
    speck = SPECK * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    return np.asarray(folded & ~noise & (np.minimum(width[left], width[right]) > speck))


def _stack(parts: list[Indices], width: int) -> Indices:
    return np.concatenate([np.zeros((0, width), dtype=np.int64), *parts])
