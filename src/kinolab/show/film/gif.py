"""Animated GIF files: each frame stores only the pixels that changed.

Pillow chooses the palette, looks colours up in it and compresses single frames. Its own saving of
all frames keeps them in memory, merges equal ones, and takes half as long again for the same bytes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import chain, pairwise
from typing import TypeAlias

import numpy as np
from PIL import Image, ImageChops
from PIL.GifImagePlugin import getdata, getheader

from kinolab.numerics.arrays import Bytes
from kinolab.show.film.crew import Crew, Share, everything
from kinolab.show.film.film import Film

Corner: TypeAlias = tuple[int, int]  # the upper left one of a part of a picture, in [pixel]
Run: TypeAlias = tuple[slice, list[Image.Image]]  # frames that follow each other, as indices

UNCHANGED = 255  # transparent index, which no colour has: shows the previous frame


def gif_parts(film: Film, share: Callable[[], Share] = everything) -> Iterator[bytes]:
    """Yield a film as the bytes of a GIF file, in chunks.

    Args:
        share: What may be taken of the computer, which changes no byte.
    """
    with Crew(share) as crew:
        # 8 frames from which the palette is chosen
        sampled = np.unique(np.linspace(0, len(film) - 1, 8).astype(int)).tolist()
        palette = crew.do(shared_palette, list(crew.in_order(film.frame, sampled)))
        loop = {"loop": 0}  # forever
        yield b"".join(getheader(palette.resize(film.script.size), info=loop)[0])
        yield from _blocks(film, palette, crew)
    yield b";"


def shared_palette(images: Sequence[Bytes]) -> Image.Image:
    """Choose a palette for several images, shape (height, width, 3) each, which avoids flicker.

    A colour is weighted by the square root of its area; otherwise a machine of a few hundred pixels
    would be lost against walls and floor of a few hundred thousand.
    """
    seen = np.concatenate([image.reshape(-1, 3) for image in images]).astype(np.uint32)
    packed = seen @ np.array([1 << 16, 1 << 8, 1], dtype=np.uint32)
    keys, counts = np.unique(packed, return_counts=True)
    sample = np.repeat(keys, np.ceil(np.sqrt(counts)).astype(int))
    rows = np.stack([sample >> 16, sample >> 8 & 255, sample & 255], axis=-1).astype(np.uint8)
    return Image.fromarray(rows[None]).quantize(UNCHANGED, Image.Quantize.MEDIANCUT, kmeans=1)


def indexed(image: Bytes, palette: Image.Image) -> Image.Image:
    """Replace RGB, shape (h, w, 3), by the nearest colours of a palette."""
    return Image.fromarray(image).quantize(palette=palette, dither=Image.Dither.NONE)


def _blocks(film: Film, palette: Image.Image, crew: Crew) -> Iterator[bytes]:
    """Frames as their differences from the ones before, several in a chunk."""
    # 100 [1/100 s] for which the last frame is shown before the loop restarts
    delays = [film.script.playback.delay] * (len(film) - 1) + [100]

    def drawn(run: slice) -> Run:
        return run, [indexed(image, palette) for image in film.shots(run)]

    def compressed(neighbours: tuple[Run, Run]) -> bytes:
        (_, before), (run, frames) = neighbours
        steps = zip(pairwise([before[-1], *frames]), delays[run], strict=True)
        return b"".join(_block(*change(new, old), delay) for (old, new), delay in steps)

    nothing: Run = (slice(0), [Image.new("P", film.script.size, UNCHANGED)])
    runs = chain([nothing], crew.in_order(drawn, film.runs()))
    yield from crew.in_order(compressed, pairwise(runs))


def change(after: Image.Image, before: Image.Image) -> tuple[Image.Image, Corner]:
    """Find what changes from one frame to the next, both as palette indices.

    Pixels that stay as they are are ``UNCHANGED``: long runs of it compress to almost nothing.

    Returns:
        The smallest rectangle with all changes, one pixel at least, and its upper left corner.
    """
    differs = ImageChops.subtract_modulo(after, before)
    window = differs.getbbox() or (0, 0, 1, 1)
    part = after.crop(window)
    part.paste(UNCHANGED, mask=differs.crop(window).point([255, *(0,) * 255], "1"))
    return part, window[:2]


def _block(part: Image.Image, corner: Corner, delay: int) -> bytes:
    """A part of a picture, its upper left corner, and how long it is shown in [1/100 s]."""
    # 1: GIF's disposal method: the next frame is drawn over this one
    options = {"duration": 10 * delay, "transparency": UNCHANGED, "disposal": 1}
    return b"".join(getdata(part, corner, **options))
