"""Meshes that are drawn and touch nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinolab.arguments import checked
from kinolab.dynamics.language.shapes.packed_rows import packed, unpacked
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.untrusted import refuse_many


@checked
@dataclass(frozen=True)
class DrawnMesh:
    """Triangles in a body's frame that are drawn and touch nothing; ``of`` makes one of arrays.

    Attributes:
        points: Corners in [m], rows of three little-endian numbers of 4 bytes, in base64.
        corners: Of each triangle three rows of ``points``, as integers of 2 bytes, likewise.
        color: Red, green and blue in [0, 1].
    """

    points: str
    corners: str
    color: tuple[float, float, float]

    def __post_init__(self) -> None:
        """Validate that all corners are there.

        Raises:
            InputError: If they are not, or there are too many triangles.
        """
        triangles = len(self.corners) // 8  # of 6 bytes, which are 8 characters
        refuse_many(triangles, "triangles that are drawn", "DrawnMesh corners", "Take fewer.")
        try:
            points, faces = self.vertices, self.faces
            sound = bool(np.isfinite(points).all()) and faces.max(initial=-1) < len(points)
        except ValueError:
            sound = False
        if not sound:
            what = "its corners and points do not fit each other, or are no numbers."
            raise InputError([Mistake("DrawnMesh", what, "Make it with DrawnMesh.of(…).")])

    @classmethod
    def of(
        cls, vertices: Array, faces: NDArray[np.int64], color: tuple[float, float, float]
    ) -> DrawnMesh:
        """Pack vertices (n, 3) in [m] and faces (m, 3); n is 65 535 at most."""
        points, corners = np.asarray(vertices, "<f4"), np.asarray(faces)
        if len(points) > np.iinfo(np.uint16).max:
            what = f"it has {len(points)} vertices."
            raise InputError([Mistake("DrawnMesh vertices", what, "Take at most 65535.")])
        return cls(packed(points, "<f4"), packed(corners, "<u2"), color)

    @property
    def vertices(self) -> Array:
        """Corners in [m], shape (n, 3)."""
        return unpacked(self.points, "<f4").astype(np.float64)

    @property
    def faces(self) -> NDArray[np.int64]:
        """Three rows of ``vertices`` each, shape (m, 3)."""
        return unpacked(self.corners, "<u2").astype(np.int64)
