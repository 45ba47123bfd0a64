"""A scene ready for rendering: fixed camera and backdrop."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import repeat

import numpy as np

from kinolab.numerics.arrays import Array, Bytes
from kinolab.show.film.models.assembly import Assembly
from kinolab.show.film.raster.contact import darken_corners
from kinolab.show.film.raster.draw_list import Layer, Shadows, drawn
from kinolab.show.film.raster.rasterizer import (
    Canvas,
    Facets,
    average,
    draw,
    extent,
    reveal,
)
from kinolab.show.film.raster.shading import Pen
from kinolab.show.film.staging.backdrop import Still
from kinolab.show.film.staging.captions import Signs, signs

PAPER, INK = (250, 250, 248), (38, 42, 50)  # PAPER is behind the sky
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
        still: What stands still.
    """

    pen: Pen
    machine: Assembly
    layers: Sequence[Layer]
    still: Still

    @cached_property
    def canvas(self) -> Canvas:
        """The backdrop in small pixels, with depth."""
        canvas = drawn(self.layers, self.pen.size, PAPER)
        darken_corners(canvas, self.pen.scale)
        return canvas

    @cached_property
    def image(self) -> Bytes:
        """The backdrop in full pixels, shape (h, w, 3)."""
        return average(self.canvas.color, self.pen.scale)

    @cached_property
    def signs(self) -> Signs:
        """Words in the picture."""
        height, width = self.image.shape[:2]
        return signs(self.still, self.pen.camera, (width, height))

    def shots(self, poses: Array, lines: Array | None) -> Iterator[Bytes]:
        """Draw pictures, shape (h, w, 3) each.

        Args:
            poses: Of the bodies, shape (nf, nb, 12).
            lines: Cables, shape (nf, nl, 2, 3), if any.
        """
        for parts in machine_facets(self.pen, self.machine, poses, lines, self.still):
            yield self._composed(*parts)

    def _composed(self, facets: Facets, shadows: list[Array]) -> Bytes:
        box = extent(np.concatenate([facets.corners, *shadows]), self.pen.size, self.pen.scale)
        part = self.canvas.part(box)
        put_machine(part, box[:2], facets, shadows, self.still)
        left, top, right, bottom = (side // self.pen.scale for side in box)
        image = self.image.copy()
        image[top:bottom, left:right] = average(part.color, self.pen.scale)
        return image


def put_machine(
    canvas: Canvas,
    corner: tuple[int, int],
    facets: Facets,
    shadows: Sequence[Array],
    still: Still,
) -> None:
    """Draw a machine and its shadows, of shape (m, 3, 3) by lamp, on a part of a picture.

    It shows through walls where one could not see it otherwise.

    Args:
        canvas: The part.
        corner: Its first column and row in the picture.
        facets: The machine.
        shadows: One entry per lamp.
        still: What stands still in the picture.
    """
    shift = np.array([*corner, 0.0])
    Shadows([corners - shift for corners in shadows]).on(canvas)
    moved = Facets(facets.corners - shift, facets.colors)
    if still.outlook.hides:
        reveal(canvas, moved)
    draw(canvas, moved)


def machine_facets(
    pen: Pen, machine: Assembly, poses: Array, lines: Array | None, still: Still
) -> Iterator[tuple[Facets, list[Array]]]:
    """Yield the machine and its cables as facets, and their shadows by lamp if any, per frame.

    Args:
        pen: Camera and light.
        machine: The bodies.
        poses: Of the bodies, shape (nf, nb, 12).
        lines: Cables, shape (nf, nl, 2, 3), if any.
        still: What stands still; on its ground there are shadows.
    """
    shadows = still.floor is not None
    moved = machine.placed(poses)
    faces, edges = pen.faces_at_poses(moved, AMBIENT), pen.edges_at_poses(moved, OUTLINE, INK)
    fallen = pen.shadows_at_poses(moved) if shadows else [[] for _ in poses]
    cables = repeat(None) if lines is None else lines
    for face, edge, dark, cable in zip(faces, edges, fallen, cables, strict=False):
        if cable is None:
            yield face + edge, dark
        else:
            both = zip(
                dark, pen.line_shadows(cable, CABLE, machine.radii) if shadows else (), strict=True
            )
            yield (
                face + edge + pen.line(cable, CABLE, INK, machine.radii),
                [np.concatenate(parts) for parts in both],
            )
