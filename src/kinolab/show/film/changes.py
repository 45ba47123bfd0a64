"""Frames as palette indices, and what changes from one to the next.

A frame differs from the backdrop only in a few boxes, and from the frame before only in the boxes
of both: nothing else is looked at.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.jit import kernel
from kinolab.show.film.palette import UNKNOWN, Palette
from kinolab.show.film.raster.rasterizer import Box

Bytes: TypeAlias = NDArray[np.uint8]

UNCHANGED = UNKNOWN  # transparent index: shows the previous frame


@dataclass(frozen=True, eq=False)
class Patches:
    """A frame as what lies over the backdrop.

    Args:
        boxes: Where, which may overlap.
        indices: Of the palette there, one array of shape (h, w) per box.
    """

    boxes: Sequence[Box]
    indices: Sequence[Bytes]

    def over(self, backdrop: Bytes) -> Bytes:
        """The whole frame, given the backdrop's indices, shape (h, w)."""
        whole = backdrop.copy()
        for (left, top, right, bottom), part in zip(self.boxes, self.indices, strict=True):
            whole[top:bottom, left:right] = part
        return whole


def patches(image: Bytes, boxes: Sequence[Box], palette: Palette) -> Patches:
    """Return a frame, RGB of shape (h, w, 3), that differs from the backdrop in boxes."""
    return Patches(boxes, [palette.indices(image, box) for box in boxes])


def change(after: Bytes, before: Bytes, boxes: Sequence[Box]) -> tuple[Bytes, tuple[int, int]]:
    """Find what changes from one frame to the next.

    Pixels that stay as they are are ``UNCHANGED``: long runs of it compress to almost nothing.

    Args:
        after: Indices of a frame, shape (h, w).
        before: Those of the frame before.
        boxes: Where they may differ.

    Returns:
        The smallest rectangle with all changes, one pixel at least, and its upper left corner.
    """
    out = np.full_like(after, UNCHANGED)
    left, top, right, bottom = _change(
        after, before, np.array(boxes, dtype=np.int64).reshape(-1, 4), out
    )
    if left >= right:
        return np.full((1, 1), UNCHANGED, dtype=np.uint8), (0, 0)
    return np.ascontiguousarray(out[top:bottom, left:right]), (left, top)


@kernel  # type: ignore[untyped-decorator]
def _change(
    after: Bytes, before: Bytes, boxes: NDArray[np.int64], out: Bytes
) -> tuple[int, int, int, int]:
    """Write the indices that differ; return where they are, half open.

    Args:
        after, before: Indices of two frames, (h, w).
        boxes: Where they may differ, (n, 4).
        out: The indices that differ, (h, w).
    """
    left, top, right, bottom = out.shape[1], out.shape[0], 0, 0
    for k in range(boxes.shape[0]):
        for i in range(boxes[k, 1], boxes[k, 3]):
            for j in range(boxes[k, 0], boxes[k, 2]):
                if after[i, j] != before[i, j]:
                    out[i, j] = after[i, j]
                    left, right = min(left, j), max(right, j + 1)
                    top, bottom = min(top, i), max(bottom, i + 1)
    return left, top, right, bottom
