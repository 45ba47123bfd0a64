"""Bodies as coloured surfaces, finer the larger they are in the picture; shapes are not needed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from kinolab.show.scene.models.surface_mesh import SurfaceMesh, join

DEGREES = (1.0, 4.0, 16.0)  # [pixel]: a radius of each degree of detail


@dataclass(frozen=True, eq=False)
class PaintedBody:
    """The surface of a body.

    Args:
        shapes: Of each shape a radius in [m], and its surface in all degrees of detail, the
            coarsest first; radius 0 and one surface where there are no others.
        whirl: In [rad/s] of film, about its z axis, with which it is drawn turning.
        prescribed: Whether it is an obstacle, which time alone moves.
    """

    name: str
    shapes: Sequence[tuple[float, Sequence[SurfaceMesh]]]
    whirl: float = 0.0
    prescribed: bool = False

    def mesh(self, pixel: float = 0.0) -> SurfaceMesh:
        """The surface in the body's frame.

        Args:
            pixel: Size of a pixel in [m], where the body is nearest; shapes small in the picture
                get fewer faces.
        """
        return join([meshes[fineness(radius, pixel)] for radius, meshes in self.shapes])


def fineness(radius: float, pixel: float) -> int:
    """Return the degree of detail that a radius in [m] needs: 0 is the coarsest."""
    # Radii [pixel] up to which the first, and the second, look round
    return sum(float(radius) > most * pixel for most in (2.0, 8.0))
