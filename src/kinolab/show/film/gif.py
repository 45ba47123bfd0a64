"""Animated GIF files: each frame stores only the pixels that changed.

Pillow compresses single frames (``getdata``). Its own saving of all frames keeps them in memory,
merges equal ones, and takes two and a half times as long for the same bytes.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from PIL.GifImagePlugin import getdata

from kinolab.show.film.film import Film
from kinolab.show.film.palette import UNKNOWN, Palette, shared_palette
from kinolab.show.film.raster.rasterizer import Box

Bytes: TypeAlias = NDArray[np.uint8]

UNCHANGED = UNKNOWN  # transparent index: shows the previous frame
KEEP = 1  # GIF's disposal method: the next frame is drawn over this one
LAST_DELAY = 100  # [1/100 s] for which the last frame is shown before the loop restarts
PALETTE_FRAMES = 8  # frames from which the palette is chosen


def gif_parts(film: Film, size: tuple[int, int]) -> Iterator[bytes]:
    """Yield a film as the bytes of a GIF file, in chunks; ``size`` in [pixel]."""
    sampled = np.unique(np.linspace(0, len(film) - 1, PALETTE_FRAMES).astype(int))
    palette = shared_palette([film.frame(i) for i in sampled])
    yield _header(size, palette)
    yield from _blocks(film, palette)
    yield b";"


def _header(size: tuple[int, int], palette: Palette) -> bytes:
    """Version, size, the palette for all frames, and the request to loop forever.

    Source: Graphics Interchange Format, Version 89a, sections 17 to 19; Netscape 2.0 extension.
    """
    colors = np.zeros((256, 3), dtype=np.uint8)
    colors[: len(palette.colors)] = palette.colors
    screen = struct.pack("<HHBBB", *size, 0xF7, UNCHANGED, 0)  # 0xF7: 256 colours, 8 bits each
    loop = b"!\xff\x0bNETSCAPE2.0\x03\x01" + struct.pack("<HB", 0, 0)
    return b"GIF89a" + screen + colors.tobytes() + loop


def _blocks(film: Film, palette: Palette) -> Iterator[bytes]:
    """Each frame as its difference from the one before."""
    before: Bytes | None = None
    for i, image in enumerate(film.frames()):
        if before is None:
            part, corner = shown, _ = palette.indices(image), (0, 0)
            changed = np.empty_like(shown)
        else:
            part, corner = _part(changed, palette.change(image, before, shown, changed))
        delay = LAST_DELAY if i == len(film) - 1 else film.playback.delay
        options = {"duration": 10 * delay, "transparency": UNCHANGED, "disposal": KEEP}
        yield b"".join(getdata(Image.fromarray(part), corner, **options))
        before = image


def _part(changed: Bytes, box: Box) -> tuple[Bytes, tuple[int, int]]:
    """The smallest rectangle that holds all changes, and its upper left corner.

    Pixels that stay as they are are ``UNCHANGED``: long runs of it compress to almost nothing.
    """
    left, top, right, bottom = box
    if left >= right:
        return np.full((1, 1), UNCHANGED, dtype=np.uint8), (0, 0)
    return np.ascontiguousarray(changed[top:bottom, left:right]), (left, top)
