"""Bodies as coloured surfaces, finer the larger they are in the picture; shapes are not needed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from kinolab.show.film.models.surface_mesh import SurfaceMesh, join

COARSE = (2.0, 8.0)  # [pixel]: radii up to which the first, and the second, look round
DEGREES = (1.0, 4.0, 16.0)  # [pixel]: a radius of each degree of detail


@dataclass(frozen=True, eq=False)
class PaintedShape:
    """The surface of a shape in its body's frame.

    Args:
        meshes: In all degrees of detail, the coarsest first, or in one.
        radius: In [m], if there are several.
    """

    meshes: Sequence[SurfaceMesh]
    radius: float = 0.0

    def mesh(self, pixel: float) -> SurfaceMesh:
        """The surface, as fine as pixels of a size in [m] need it."""
        return self.meshes[fineness(self.radius, pixel) if len(self.meshes) > 1 else 0]


@dataclass(frozen=True, eq=False)
class PaintedBody:
    """The surface of a body.

    Args:
        name: Its name.
        shapes: Its shapes.
        whirl: In [rad/s] of film, about its z axis, with which it is drawn turning.
    """

    name: str
    shapes: Sequence[PaintedShape]
    whirl: float = 0.0

    def mesh(self, pixel: float = 0.0) -> SurfaceMesh:
        """The surface in the body's frame.

        Args:
            pixel: Size of a pixel in [m], where the body is nearest; shapes small in the picture
                get fewer faces.
        """
        return join([shape.mesh(pixel) for shape in self.shapes])


def fineness(radius: float, pixel: float) -> int:
    """Return the degree of detail that a radius in [m] needs: 0 is the coarsest."""
    return sum(float(radius) > most * pixel for most in COARSE)
