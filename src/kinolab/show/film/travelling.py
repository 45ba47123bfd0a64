"""A picture that goes with the machine: each frame is a window of a large backdrop."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.show.film.inset import Inset
from kinolab.show.film.raster.rasterizer import Bytes
from kinolab.show.film.staging.backdrop import Still
from kinolab.show.film.staging.captions import NO_SIGNS, Signs

BRIGHT, DARK = (255, 255, 255), (22, 24, 32)


@dataclass(frozen=True, eq=False)
class Travelling:
    """Draws a machine in the middle of every frame; the whole picture changes from one to the next.

    Args:
        window: What is seen, as large as a frame.
        size: Width and height of a frame in [pixel].
    """

    window: Inset
    size: tuple[int, int]

    @property
    def still(self) -> Still:
        """What stands still."""
        return self.window.still

    @property
    def around(self) -> tuple[int, int, int]:
        """What surrounds the letters of title and time: the window shows all kinds of things."""
        return DARK if self.still.picture.colors.is_dark else BRIGHT

    @property
    def signs(self) -> Signs:
        """Words in the picture: none, as their places change."""
        return NO_SIGNS

    @cached_property
    def image(self) -> Bytes:
        """What is behind all frames: nothing, as each of them covers it."""
        width, height = self.size
        return np.zeros((height, width, 3), dtype=np.uint8)

    def shots(self, poses: Array, lines: Array | None) -> Iterator[Bytes]:
        """Draw pictures, shape (h, w, 3) each.

        Args:
            poses: Of the bodies, shape (nf, nb, 12).
            lines: Cables, shape (nf, nl, 2, 3), if any.
        """
        return self.window.views(poses, lines)
