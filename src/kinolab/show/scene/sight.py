"""Who hides whom: faces between a camera and points, found without drawing anything."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.show.scene.camera import Camera
from kinolab.show.scene.models.surface_mesh import Indices, normals

NEARER = 2e-3  # fraction of a point's depth by which a face must be nearer to hide it
SEEN = -1


@dataclass(frozen=True, eq=False)
class Screens:
    """Faces that may stand in front of something.

    Args:
        vertices: In [m], shape (n, 3).
        faces: Three vertices each, shape (m, 3).
        one_sided: Which of them are invisible from behind, shape (m,), as those of a room.
    """

    vertices: Array
    faces: Indices
    one_sided: NDArray[np.bool_]

    def part(self, faces: NDArray[np.intp]) -> Screens:
        """Some of the faces, by their indices."""
        return Screens(self.vertices, self.faces[faces], self.one_sided[faces])

    def hiding(self, camera: Camera, points: Array) -> NDArray[np.int64]:
        """The nearest face that hides each point, shape (n,); ``SEEN`` where nothing does.

        Args:
            camera: From where one looks; all faces and points are in front of it.
            points: Shape (n, 3), in [m].
        """
        # (1, 1) [pixel] is a picture in which only places matter
        seen = camera.project(self.vertices, (1, 1)).astype(np.float32)
        corners = seen[self.faces]
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        low, high = (pick(pick(a, b), c) for pick in (np.minimum, np.maximum))
        near = np.where(self._turned_away(camera), np.inf, low[:, 2])
        found = np.full(len(points), SEEN, dtype=np.int64)
        for k, (x, y, depth) in enumerate(camera.project(points, (1, 1))):
            over = (low[:, 0] <= x) & (high[:, 0] >= x) & (low[:, 1] <= y) & (high[:, 1] >= y)
            faces = np.flatnonzero(over & (near < depth * (1.0 - NEARER)))
            depths = _depths(corners[faces].astype(np.float64), x, y)
            depths[depths >= depth * (1.0 - NEARER)] = np.inf
            if len(faces) and np.isfinite(depths.min()):
                found[k] = faces[np.argmin(depths)]
        return found

    def _turned_away(self, camera: Camera) -> NDArray[np.bool_]:
        turned = np.zeros(len(self.faces), dtype=bool)
        rooms = np.flatnonzero(self.one_sided)
        corner = self.vertices[self.faces[rooms, 0]]
        facing = np.sum(
            normals(self.vertices, self.faces[rooms]) * (camera.position - corner), axis=1
        )
        turned[rooms] = facing <= 0.0
        return turned


def _depths(corners: Array, x: float, y: float) -> Array:
    """Depths at which a line of sight meets projected triangles (m, 3, 3); inf where it does not.

    1 / depth is linear in the picture, as the rasteriser has it.
    """
    a, b, c = (corners[:, i, :2] - (x, y) for i in range(3))
    areas = np.stack([_cross(b, c), _cross(c, a), _cross(a, b)], axis=1)
    whole = areas.sum(axis=1)
    inside = (areas >= 0.0).all(axis=1) | (areas <= 0.0).all(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        nearness = np.sum(areas / corners[:, :, 2], axis=1) / whole
        return np.where(inside & (whole != 0.0), 1.0 / nearness, np.inf)


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
