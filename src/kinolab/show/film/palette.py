"""A palette shared by all frames of a film, which avoids flicker."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image

from kinolab.numerics.arrays import Bytes
from kinolab.numerics.jit import kernel

COLORS = 255  # one of 256 indices stays free to mean "unchanged"
UNKNOWN = 255  # the index that stays free
BITS = 6  # per channel in the look-up table: colours within 4/255 share an index
DROPPED = 8 - BITS


@dataclass(frozen=True, eq=False)
class Palette:
    """Colours and the index of the nearest one.

    Args:
        colors: RGB, shape (COLORS, 3).
        table: Index by red, green and blue of ``BITS`` bits each, flat; ``UNKNOWN`` until it is
            looked up.
    """

    colors: Bytes
    table: Bytes

    def indices(self, image: Bytes) -> Bytes:
        """Replace RGB, shape (h, w, 3), by the nearest colour's index, shape (h, w)."""
        out = np.empty(image.shape[:2], dtype=np.uint8)
        _look_up(image, self.colors, self.table, out)
        return out


def shared_palette(images: Sequence[Bytes]) -> Palette:
    """Choose a palette for several images, shape (height, width, 3) each.

    A colour is weighted by the square root of its area; otherwise a machine of a few hundred pixels
    would be lost against walls and floor of a few hundred thousand.
    """
    seen = np.concatenate([image.reshape(-1, 3) for image in images]).astype(np.uint32)
    packed = seen @ np.array([1 << 16, 1 << 8, 1], dtype=np.uint32)
    keys, counts = np.unique(packed, return_counts=True)
    sample = np.repeat(keys, np.ceil(np.sqrt(counts)).astype(int))
    rows = np.stack([sample >> 16, sample >> 8 & 255, sample & 255], axis=-1).astype(np.uint8)
    reduced = Image.fromarray(rows[None]).quantize(COLORS, Image.Quantize.MEDIANCUT, kmeans=1)
    used = np.array(reduced.getpalette() or [], dtype=np.uint8).reshape(-1, 3)[:COLORS]
    colors = np.zeros((COLORS, 3), dtype=np.uint8)
    colors[: len(used)] = used
    return Palette(colors, np.full(1 << 3 * BITS, UNKNOWN, dtype=np.uint8))


@kernel  # type: ignore[untyped-decorator]
def _look_up(image: Bytes, colors: Bytes, table: Bytes, out: Bytes) -> None:
    """Find the index of the colour nearest to each pixel, which the table remembers.

    Args:
        image: RGB, (h, w, 3).
        colors, table: Of ``Palette``, (COLORS, 3) and flat.
        out: The indices, (h, w).
    """
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            red, green, blue = image[i, j, 0], image[i, j, 1], image[i, j, 2]
            place = ((red >> DROPPED) << BITS | green >> DROPPED) << BITS | blue >> DROPPED
            if table[place] == UNKNOWN:
                best, least, middle = 0, 1 << 30, 1 << DROPPED >> 1
                for k in range(colors.shape[0]):
                    dr = (red >> DROPPED << DROPPED) + middle - np.int64(colors[k, 0])
                    dg = (green >> DROPPED << DROPPED) + middle - np.int64(colors[k, 1])
                    db = (blue >> DROPPED << DROPPED) + middle - np.int64(colors[k, 2])
                    # The eye sees green best and blue least; the weights are the usual 3 : 6 : 1.
                    distance = 3 * dr * dr + 6 * dg * dg + db * db
                    if distance < least:
                        best, least = k, distance
                table[place] = best
            out[i, j] = table[place]
