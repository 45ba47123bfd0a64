"""Shading: meshes in the world to facets in the picture, faces and edges.

What moves is drawn at many poses at once: a film has hundreds, and each call of NumPy takes longer
than the few facets of a machine.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.numerics.arrays import Array
from kinolab.show.film.raster.light import AMBIENT, light_samples, main_light, shade, shadow_points
from kinolab.show.film.raster.rasterizer import Facets
from kinolab.show.film.raster.stroke import strokes
from kinolab.show.scene.camera import Camera
from kinolab.show.scene.models.surface_mesh import SurfaceMesh

EDGE_LEAD = 8e-4  # of the distance to the viewer: 2 cm in a room of 10 m


@dataclass(frozen=True, eq=False)
class Pen:
    """Draws for one camera, one light and one canvas.

    Args:
        size: Width and height of the canvas in its own, small pixels.
        light: Direction toward the light, shape (3,).
        scale: Small pixels per pixel of the finished picture.
    """

    camera: Camera
    size: tuple[int, int]
    light: Array
    scale: int

    def at(self, points: ArrayLike) -> Array:
        """Column, row and nearness of points, shape (..., 3)."""
        seen = self.camera.project(points, self.size)
        with np.errstate(divide="ignore"):
            seen[..., 2] = 1.0 / seen[..., 2]
        return seen

    def faces(self, mesh: SurfaceMesh) -> Facets:
        """All faces, shaded."""
        return self.faces_at_poses(_as_one_pose(mesh), AMBIENT)[0]

    def faces_at_poses(self, mesh: SurfaceMesh, ambient: float) -> list[Facets]:
        """All faces, shaded, of a mesh at nf poses, whose vertices are of shape (nf, n, 3)."""
        corners = self.at(mesh.vertices)[:, mesh.faces]
        normal, front = self._facing(mesh)
        toward_viewer = np.where(front[..., None], normal, -normal)
        colors = shade(mesh.colors, toward_viewer, self.light, ambient)
        return [Facets(*drawn) for drawn in zip(corners, colors, strict=True)]

    def front_faces(self, mesh: SurfaceMesh) -> Facets:
        """Only the faces toward the viewer, so that a room's near walls are invisible."""
        facets, front = self.faces(mesh), self._facing(mesh)[1]
        return Facets(facets.corners[front], facets.colors[front])

    def silhouette(self, mesh: SurfaceMesh, width: float, color: ArrayLike) -> Facets:
        """Where faces toward the viewer meet such that look away; width in [pixel]."""
        front = self._facing(mesh)[1][mesh.sides]
        outline = mesh.ends[front[:, 0] != front[:, 1]]
        return strokes(self.at(mesh.vertices)[outline], width * self.scale, color, EDGE_LEAD)

    def edges(self, mesh: SurfaceMesh, width: float, color: ArrayLike) -> Facets:
        """Visible creases, and the silhouette of curved surfaces.

        The width is in [pixel], the colour RGB in 0..255: one, or one per face.
        """
        return self.edges_at_poses(_as_one_pose(mesh), width, color)[0]

    def edges_at_poses(self, mesh: SurfaceMesh, width: float, color: ArrayLike) -> list[Facets]:
        """The same of a mesh at nf poses, whose vertices are of shape (nf, n, 3)."""
        front = self._facing(mesh)[1][:, mesh.sides]
        inked = (mesh.creases & front.any(axis=-1)) | (front[..., 0] != front[..., 1])
        pose, edge = np.nonzero(inked)
        segments = self.at(mesh.vertices)[pose[:, None], mesh.ends[edge]]
        seen = np.isfinite(segments).all(axis=(1, 2))
        colors = np.asarray(color)
        if colors.ndim == 2:  # of faces: an edge takes that of one beside it
            colors = np.repeat(colors[mesh.sides[edge[seen], 0]], 2, axis=0)
        drawn = strokes(segments[seen], width * self.scale, colors, EDGE_LEAD)
        ends = 2 * np.cumsum(np.bincount(pose[seen], minlength=len(inked)))[:-1]  # triangles
        parts = zip(np.split(drawn.corners, ends), np.split(drawn.colors, ends), strict=True)
        return [Facets(*part) for part in parts]

    def line(
        self, segments: ArrayLike, width: float, color: ArrayLike, radii: Array | None = None
    ) -> Facets:
        """Segments of the world, shape (n, 2, 3).

        Args:
            segments: Their ends.
            width: In [pixel].
            color: RGB in 0..255.
            radii: In [m], shape (n,): each is drawn as wide as a tube, but no thinner than width.
        """
        seen = self.at(segments)
        return strokes(seen, self._widths(seen, width, radii), color)

    def _widths(self, seen: Array, width: float, radii: Array | None) -> Array:
        """Return the widths of segments at both ends, in small pixels, shape (n, 2)."""
        thinnest = np.full(seen.shape[:2], width * self.scale)
        if radii is None or not len(radii):
            return thinnest
        focal = 0.5 * self.size[1] / np.tan(0.5 * self.camera.fov)
        return np.asarray(np.fmax(thinnest, 2.0 * radii[:, None] * focal * seen[..., 2]))

    def shadows(self, mesh: SurfaceMesh) -> list[Array]:
        """The mesh's shadow on the ground for every lamp, as triangles of shape (m, 3, 3).

        For a closed surface above the ground, the faces toward a lamp suffice.
        """
        return self.shadows_at_poses(_as_one_pose(mesh))[0]

    def shadows_at_poses(self, mesh: SurfaceMesh) -> list[list[Array]]:
        """The same of a mesh at nf poses, whose vertices are of shape (nf, n, 3), pose by pose."""
        lowest = mesh.vertices[..., 2].min(axis=-1, initial=0.0)
        whole = (lowest <= -1e-6) | (not mesh.is_closed)  # [m] below the ground: rounding
        lamps = self._lamps[:, None, :]
        places = self.at(shadow_points(mesh.vertices[:, None], lamps))
        lit = whole[:, None, None] | (self._lamps @ mesh.normals.swapaxes(-1, -2) > 0.0)
        return [
            [fallen[mesh.faces[own]] for fallen, own in zip(*lamp, strict=True)]
            for lamp in zip(places, lit, strict=True)
        ]

    def line_shadows(
        self, segments: ArrayLike, width: float, radii: Array | None = None
    ) -> list[Array]:
        """The shadows of segments as strokes; arguments as for ``line``."""
        points = np.asarray(segments, dtype=np.float64)
        places = [self.at(shadow_points(points, lamp)) for lamp in self._lamps]
        return [
            strokes(seen, self._widths(seen, width, radii), (0, 0, 0)).corners for seen in places
        ]

    @cached_property
    def _lamps(self) -> Array:
        return light_samples(self.light)

    def _facing(self, mesh: SurfaceMesh) -> tuple[Array, NDArray[np.bool_]]:
        normal = mesh.normals
        to_viewer = self.camera.position - mesh.vertices[..., mesh.faces[:, 0], :]
        return normal, np.sum(normal * to_viewer, axis=-1) > 0.0


def _as_one_pose(mesh: SurfaceMesh) -> SurfaceMesh:
    return replace(mesh, vertices=mesh.vertices[None])


def pen(camera: Camera, size: tuple[int, int], up: Array, scale: int) -> Pen:
    """A pen for a picture of (w, h) pixels, supersampled by scale x scale."""
    return Pen(camera, (scale * size[0], scale * size[1]), main_light(camera, up), scale)
