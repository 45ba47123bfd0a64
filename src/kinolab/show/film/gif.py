"""Animated GIF files: each frame stores only the pixels that changed.

Pillow compresses single frames (``getdata``). Its own saving of all frames keeps them in memory,
merges equal ones, and takes two and a half times as long for the same bytes.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image
from PIL.GifImagePlugin import getdata

from kinolab.files import whole_file
from kinolab.show.film.film import Film, make_film
from kinolab.show.film.palette import Palette, shared_palette
from kinolab.show.film.picture import Picture

Bytes: TypeAlias = NDArray[np.uint8]

UNCHANGED = 255  # transparent index: shows the previous frame
KEEP = 1  # GIF's disposal method: the next frame is drawn over this one
LAST_DELAY = 100  # [1/100 s] for which the last frame is shown before the loop restarts
PALETTE_FRAMES = 8  # frames from which the palette is chosen


def write_gif(
    path: Path | str,
    picture: Picture,
    times: ArrayLike,
    poses: ArrayLike,
    *,
    size: tuple[int, int] = (800, 600),
    fps: float = 25.0,
    speed: float = 1.0,
    title: str = "",
) -> None:
    """Render a motion to a GIF file, written atomically.

    Args:
        path: Where to write; an existing file is replaced.
        picture: The picture to draw.
        times: Row times in [s], shape (nt,), not decreasing.
        poses: One pose per row and body, shape (nt, nb, 12).
        size: Width and height in [pixel].
        fps: Frames per second of film; GIF can only show 100 / n of them for whole n.
        speed: Seconds of motion per second of film; raised if more than 400 frames were needed.
        title: One line of text.

    Raises:
        ValueError: If the motion is not finite, not in order, or does not fit the bodies.
        OSError: If the file cannot be written.
    """
    film = make_film(picture, times, poses, size=size, fps=fps, speed=speed, title=title)
    with whole_file(Path(path)) as file:
        file.writelines(gif_parts(film, size))


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
    shown: Bytes | None = None
    for i, image in enumerate(film.frames()):
        indices = palette.indices(image)
        changed, corner = _difference(indices, shown)
        delay = LAST_DELAY if i == len(film) - 1 else film.playback.delay
        options = {"duration": 10 * delay, "transparency": UNCHANGED, "disposal": KEEP}
        part = Image.fromarray(np.ascontiguousarray(changed))
        yield b"".join(getdata(part, corner, **options))
        shown = indices


def _difference(indices: Bytes, shown: Bytes | None) -> tuple[Bytes, tuple[int, int]]:
    """The smallest rectangle that holds all changes, and its upper left corner.

    Pixels that stay as they are become ``UNCHANGED``: long runs of it compress to almost nothing.
    """
    if shown is None:
        return indices, (0, 0)
    changes = indices != shown
    rows, columns = np.flatnonzero(changes.any(axis=1)), np.flatnonzero(changes.any(axis=0))
    if len(rows) == 0:
        return np.full((1, 1), UNCHANGED, dtype=np.uint8), (0, 0)
    box = (slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1))
    part = np.where(changes[box], indices[box], np.uint8(UNCHANGED))
    return part, (int(columns[0]), int(rows[0]))
