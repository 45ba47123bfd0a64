"""A scene ready for rendering: fixed camera and backdrop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from kinolab.numerics.arrays import Array
from kinolab.show.film.models.assembly import Assembly
from kinolab.show.film.picture import Floor
from kinolab.show.film.raster.draw_list import Layer, Shadows, drawn
from kinolab.show.film.raster.rasterizer import Bytes, Canvas, Facets, average, draw, extent
from kinolab.show.film.raster.shading import Pen

PAPER, INK = (250, 250, 248), (38, 42, 50)
SUPERSAMPLING = 3  # small pixels per pixel and axis
OUTLINE, CABLE = 0.8, 1.6  # [pixel]
AMBIENT = 0.80  # the machine is shaded less than the walls, as colours distinguish its bodies


@dataclass(frozen=True, eq=False)
class Scene:
    """Draws the machine over a backdrop; only the pixels that it covers are redrawn.

    Args:
        pen: Camera and light.
        machine: The bodies.
        layers: The backdrop, in drawing order.
        floor: Ground for the machine's shadow, if there is any.
    """

    pen: Pen
    machine: Assembly
    layers: Sequence[Layer]
    floor: Floor | None

    @cached_property
    def canvas(self) -> Canvas:
        """The backdrop in small pixels, with depth."""
        return drawn(self.layers, self.pen.size, PAPER)

    @cached_property
    def image(self) -> Bytes:
        """The backdrop in full pixels, shape (h, w, 3)."""
        return average(self.canvas.color, self.pen.scale)

    def shot(self, poses: ArrayLike, lines: Array | None = None) -> Bytes:
        """The picture with the machine at poses, shape (nb, 12), and cables, shape (nl, 2, 3)."""
        parts = machine_facets(
            self.pen, self.machine, pose_table(poses), lines, self.floor is not None
        )
        return self._composed(*parts)

    def _composed(self, facets: Facets, shadows: list[Array]) -> Bytes:
        box = extent(np.concatenate([facets.corners, *shadows]), self.pen.size, self.pen.scale)
        part = self.canvas.part(box)
        shift = np.array([box[0], box[1], 0.0])
        Shadows([corners - shift for corners in shadows]).on(part)
        draw(part, Facets(facets.corners - shift, facets.colors))
        left, top, right, bottom = (side // self.pen.scale for side in box)
        image = self.image.copy()
        image[top:bottom, left:right] = average(part.color, self.pen.scale)
        return image


def machine_facets(
    pen: Pen, machine: Assembly, poses: Array, lines: Array | None, shadows: bool
) -> tuple[Facets, list[Array]]:
    """Return the machine and its cables as facets, and their shadows by lamp if any.

    Args:
        pen: Camera and light.
        machine: The bodies.
        poses: Of the bodies, shape (nb, 12).
        lines: Cables, shape (nl, 2, 3), if any.
        shadows: Whether there is ground for shadows.
    """
    moved = machine.placed(poses)
    facets = pen.faces(moved, AMBIENT) + pen.edges(moved, OUTLINE, INK)
    fallen = pen.shadows(moved) if shadows else []
    if lines is not None:
        facets += pen.line(lines, CABLE, INK)
        if shadows:
            both = zip(fallen, pen.line_shadows(lines, CABLE), strict=True)
            fallen = [np.concatenate(parts) for parts in both]
    return facets, fallen


def pose_table(poses: ArrayLike) -> Array:
    """Poses given as (..., nb, 12) or (..., nb, 3, 4), as rows of 12 numbers."""
    table = np.asarray(poses, dtype=np.float64)
    return table.reshape(*table.shape[:-2], 12) if table.shape[-2:] == (3, 4) else table
