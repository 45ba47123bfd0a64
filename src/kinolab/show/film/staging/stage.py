"""The stage of a film: the camera that sees everything, and the backdrop, corners darkened."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import repeat

import numpy as np

from kinolab.numerics.arrays import Array, Bytes
from kinolab.show.film.raster.draw_list import Layer, Shadows, drawn
from kinolab.show.film.raster.rasterizer import (
    NO_FACETS,
    Canvas,
    Facets,
    average,
    draw,
    extent,
    reveal,
)
from kinolab.show.film.raster.shading import Pen, pen
from kinolab.show.film.staging.assembly import Assembly
from kinolab.show.film.staging.backdrop import backdrop
from kinolab.show.film.staging.drawn_axes import axes_at, put_names
from kinolab.show.film.staging.signs import Signs, signs
from kinolab.show.scene.camera import frame_scene
from kinolab.show.scene.frame_axes import axis_length
from kinolab.show.scene.picture import Picture
from kinolab.show.scene.still import INK, Still, set_up

PAPER = (250, 250, 248)  # behind the sky
OUTLINE, CABLE = 0.8, 1.6  # [pixel]
REACHES = (2, 7)  # [pixel] of an 800 x 600 picture
DIRECTIONS = ((1, 0), (0, 1), (1, 1), (1, -1))


@dataclass(frozen=True, eq=False)
class Stage:
    """Draws the machine over a backdrop; only the pixels that it covers are redrawn.

    Args:
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

    def shots(
        self, poses: Array, lines: Array | None, axes: Array | None = None
    ) -> Iterator[Bytes]:
        """Draw pictures, shape (h, w, 3) each.

        Args:
            poses: Of the bodies, shape (nf, nb, 12).
            lines: Cables, shape (nf, nl, 2, 3), if any.
            axes: Poses of frames whose axes are drawn, shape (nf, n, 12), if any.
        """
        moving = machine_facets(self.pen, self.machine, poses, lines, self.still, axes)
        for k, parts in enumerate(moving):
            image = self._composed(*parts)
            if axes is not None:
                name_frames(image, self.still, self.pen, axes[k])
            yield image

    def _composed(self, facets: Facets, shadows: list[Array]) -> Bytes:
        box = extent(np.concatenate([facets.corners, *shadows]), self.pen.size, self.pen.scale)
        part = self.canvas.part(box)
        put_machine(part, box[:2], facets, shadows, self.still)
        left, top, right, bottom = (side // self.pen.scale for side in box)
        image = self.image.copy()
        image[top:bottom, left:right] = average(part.color, self.pen.scale)
        return image


def build_stage(picture: Picture, motion: Array, size: tuple[int, int]) -> Stage:
    """Place the camera to frame everything, and set up the backdrop.

    Args:
        picture: The picture to draw.
        motion: Poses that the picture must contain, shape (nt, nb, 12).
        size: Width and height of the picture in [pixel].
    """
    still, cloud = set_up(picture, motion)
    camera = frame_scene(cloud, picture.up, picture.view, size, angles=still.outlook.angles)
    up = np.asarray(picture.up, dtype=np.float64) / np.linalg.norm(picture.up)
    tool = pen(camera, size, up, 3)  # small pixels per pixel and axis
    machine = picture.machine(camera.nearest_pixel(still.paths, size))
    layers, body = backdrop(still, machine, tool), Assembly(machine, picture.radii)
    return Stage(tool, body, layers, still)


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
        corner: Its first column and row in the picture.
        shadows: One entry per lamp.
        still: What stands still in the picture.
    """
    shift = np.array([*corner, 0.0])
    Shadows([corners - shift for corners in shadows]).on(canvas)
    moved = Facets(facets.corners - shift, facets.colors)
    if still.outlook.hides:
        reveal(canvas, moved)
    draw(canvas, moved)


def name_frames(
    image: Bytes, still: Still, pen: Pen, poses: Array, corner: tuple[int, int] = (0, 0)
) -> None:
    """Write the names of frames at poses (n, 12) on an image, a part of the pen's canvas."""
    if still.picture.frames is not None:
        places = (pen.at(poses[:, 3::4]) - (*corner, 0.0)) / (pen.scale, pen.scale, 1.0)
        put_names(image, still.picture.frames.names, places, (still.words, still.around))


def machine_facets(
    pen: Pen,
    machine: Assembly,
    poses: Array,
    lines: Array | None,
    still: Still,
    axes: Array | None = None,
) -> Iterator[tuple[Facets, list[Array]]]:
    """Yield the machine and its cables as facets, and their shadows by lamp if any, per frame.

    Args:
        poses: Of the bodies, shape (nf, nb, 12).
        lines: Cables, shape (nf, nl, 2, 3), if any.
        still: What stands still; on its ground there are shadows.
        axes: Poses of frames whose axes are drawn, shape (nf, n, 12), if any.
    """
    shadows = still.floor is not None
    moved = machine.placed(poses)
    # 0.80: the machine is shaded less than the walls, as colours distinguish its bodies
    faces, edges = pen.faces_at_poses(moved, 0.80), pen.edges_at_poses(moved, OUTLINE, INK)
    fallen = pen.shadows_at_poses(moved) if shadows else [[] for _ in poses]
    cables = repeat(None) if lines is None else lines
    length = 0.0 if axes is None else axis_length(still.reach, still.size, axes.shape[1])
    drawn_axes = repeat(NO_FACETS) if axes is None else (axes_at(pen, at, length) for at in axes)
    for face, edge, dark, cable, axis in zip(
        faces, edges, fallen, cables, drawn_axes, strict=False
    ):
        if cable is None:
            yield face + edge + axis, dark
        else:
            both = zip(
                dark, pen.line_shadows(cable, CABLE, machine.radii) if shadows else (), strict=True
            )
            yield (
                face + edge + pen.line(cable, CABLE, INK, machine.radii) + axis,
                [np.concatenate(parts) for parts in both],
            )


def darken_corners(canvas: Canvas, scale: int) -> None:
    """Darken hollow places of a canvas of scale x scale small pixels per pixel."""
    middle = scale // 2
    near = canvas.nearness[middle::scale, middle::scale]
    dark = 0.42 * _hollowness(near.astype(np.float32))  # how much darker the deepest corner is
    rows, columns = np.nonzero(dark > 0.03)  # darkness that one sees
    height, width = near.shape
    blocks = canvas.color[: height * scale, : width * scale].reshape(height, scale, width, scale, 3)
    left = (1.0 - dark[rows, columns])[:, None, None, None]
    blocks[rows, :, columns] = (blocks[rows, :, columns] * left + 0.5).astype(np.uint8)


def _hollowness(near: Array) -> Array:
    """How hollow a surface is at each pixel, from 0 to 1, from 1 / depth, shape (h, w)."""
    height, width = near.shape
    most = max(REACHES)
    wide = np.pad(near, most, mode="edge")
    total = np.zeros_like(near)

    def at(dx: int, dy: int) -> Array:
        return wide[most + dy : most + dy + height, most + dx : most + dx + width]

    floor = np.maximum(near, np.float32(1e-12))
    for reach in REACHES:
        for dx, dy in DIRECTIONS:
            a, b = at(reach * dx, reach * dy), at(-reach * dx, -reach * dy)
            bend = (0.5 * (a + b) - near) / floor
            # 0.03 of 1 / depth: what is so much nearer stands before it, not beside it
            beside = (np.maximum(a, b) < (1.0 + 0.03) * near) & (np.minimum(a, b) > 0.0)
            # 6e-3 of 1 / depth: what counts as the deepest corner
            total += np.where(beside, np.clip(bend / 6e-3, 0.0, 1.0), 0.0)
    return np.asarray(np.where(near > 0.0, total / (len(REACHES) * len(DIRECTIONS)), 0.0))
