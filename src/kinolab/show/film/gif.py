"""Animated GIF files: each frame stores only the pixels that changed.

Pillow compresses single frames (``getdata``). Its own saving of all frames keeps them in memory,
merges equal ones, and takes two and a half times as long for the same bytes.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from itertools import chain, pairwise
from typing import TypeAlias

import numpy as np
from PIL import Image
from PIL.GifImagePlugin import getdata

from kinolab.numerics.arrays import Bytes
from kinolab.show.film.crew import Crew, Share, everything
from kinolab.show.film.film import Film
from kinolab.show.film.palette import UNKNOWN, Palette, shared_palette

Part: TypeAlias = tuple[Bytes, tuple[int, int]]  # palette indices and their upper left corner
Run: TypeAlias = tuple[slice, list[Bytes]]  # frames that follow each other, as palette indices

UNCHANGED = UNKNOWN  # transparent index: shows the previous frame
KEEP = 1  # GIF's disposal method: the next frame is drawn over this one
LAST_DELAY = 100  # [1/100 s] for which the last frame is shown before the loop restarts
PALETTE_FRAMES = 8  # frames from which the palette is chosen


def gif_parts(film: Film, share: Callable[[], Share] = everything) -> Iterator[bytes]:
    """Yield a film as the bytes of a GIF file, in chunks.

    Args:
        film: The film.
        share: What may be taken of the computer, which changes no byte.
    """
    with Crew(share) as crew:
        sampled = np.unique(np.linspace(0, len(film) - 1, PALETTE_FRAMES).astype(int)).tolist()
        palette = crew.do(shared_palette, list(crew.in_order(film.frame, sampled)))
        yield _header(film.script.size, palette)
        yield from _blocks(film, palette, crew)
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


def _blocks(film: Film, palette: Palette, crew: Crew) -> Iterator[bytes]:
    """Frames as their differences from the ones before, several in a chunk."""
    delays = [film.script.playback.delay] * (len(film) - 1) + [LAST_DELAY]

    def drawn(run: slice) -> Run:
        return run, [palette.indices(image) for image in film.shots(run)]

    def compressed(neighbours: tuple[Run, Run]) -> bytes:
        (_, before), (run, frames) = neighbours
        parts = _changes(before[-1:], frames)
        return b"".join(
            _block(*part, delay) for part, delay in zip(parts, delays[run], strict=True)
        )

    nothing: Run = (slice(0, 0), [])
    runs = chain([nothing], crew.in_order(drawn, film.runs()))
    yield from crew.in_order(compressed, pairwise(runs))


def _changes(before: list[Bytes], frames: list[Bytes]) -> Iterator[Part]:
    """What each frame changes; the first one of a film, which has none before it, is whole."""
    if not before:
        yield frames[0], (0, 0)
    for old, new in pairwise(before + frames):
        yield change(new, old)


def change(after: Bytes, before: Bytes) -> Part:
    """Find what changes from one frame to the next, palette indices of shape (h, w).

    Pixels that stay as they are are ``UNCHANGED``: long runs of it compress to almost nothing.

    Returns:
        The smallest rectangle with all changes, one pixel at least, and its upper left corner.
    """
    differs = after != before
    rows, columns = (np.flatnonzero(differs.any(axis=k)) for k in (1, 0))
    if not len(rows):
        return np.full((1, 1), UNCHANGED, dtype=np.uint8), (0, 0)
    top, left = int(rows[0]), int(columns[0])
    window = np.s_[top : rows[-1] + 1, left : columns[-1] + 1]
    return np.where(differs[window], after[window], np.uint8(UNCHANGED)), (left, top)


def _block(indices: Bytes, corner: tuple[int, int], delay: int) -> bytes:
    """A part of a picture, its upper left corner, and how long it is shown in [1/100 s]."""
    options = {"duration": 10 * delay, "transparency": UNCHANGED, "disposal": KEEP}
    return b"".join(getdata(Image.fromarray(indices), corner, **options))
