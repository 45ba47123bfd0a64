"""Title, time stamp and labels on images."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from threading import Lock
from typing import TypeAlias

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from kinolab.numerics.arrays import Bytes
from kinolab.show.film.raster.rasterizer import Box

Mark: TypeAlias = Callable[[ImageDraw.ImageDraw, int], None]  # draws with letters, so much wider

TITLE, STAMP = (38, 42, 50), (96, 100, 108)
HALO = 2  # [pixel] around the letters of a word in the picture
PLAIN, BOLD = "DejaVuSans.ttf", "DejaVuSans-Bold.ttf"
FONTS = Path(__file__).parent / "fonts"  # DejaVu Sans, which has letters for most languages

_setting = Lock()  # FreeType's faces belong to one thread at a time


@dataclass(frozen=True, eq=False)
class Words:
    """Words at their place in a picture.

    Args:
        mask: How much of each pixel they cover.
        left: First column, in [pixel].
        top: First row, in [pixel].
    """

    mask: Image.Image
    left: int
    top: int

    @property
    def box(self) -> Box:
        """Where they are."""
        return self.left, self.top, self.left + self.mask.width, self.top + self.mask.height

    def meets(self, b: Box) -> bool:
        """Whether they cover a part of a box."""
        a = self.box
        return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]

    def moved(self, columns: float, rows: float) -> Words:
        """The same words at another place, so many pixels away."""
        return replace(self, left=self.left + round(columns), top=self.top + round(rows))

    def on(self, image: Bytes, color: tuple[int, int, int]) -> None:
        """Write them on an image, shape (h, w, 3)."""
        wide, high = self.mask.size
        part = image[self.top : self.top + high, self.left : self.left + wide]
        sheet = Image.fromarray(np.ascontiguousarray(part))
        sheet.paste(color, (0, 0), self.mask)
        part[:] = np.asarray(sheet)


def letter(
    image: Bytes,
    title: str,
    stamp: str,
    color: tuple[int, int, int] = TITLE,
    around: tuple[int, int, int] | None = None,
) -> None:
    """Write a title at the upper left of an image, and a time stamp at the right.

    Args:
        image: RGB pixels, shape (h, w, 3).
        title: One line of text.
        around: Of what surrounds them, where they stand before all kinds of things.
    """
    height, width = image.shape[:2]
    size, edge = _sizes(height)
    page = (width, min(height, heading(height)))
    room = int(width - 3 * edge - _length(stamp, PLAIN, size))
    parts = (
        (title, BOLD, _fitting(title, size, room), (edge, edge), "la", page),
        (stamp, PLAIN, size, (width - edge, edge), "ra", page),
    )
    if around is not None:
        for part in parts:
            _words(*part, HALO).on(image, around)
    pale = STAMP if color == TITLE and around is None else color
    for part, ink in zip(parts, (color, pale), strict=True):
        _words(*part).on(image, ink)


@lru_cache(maxsize=64)  # a longer stamp leaves less space
def _fitting(title: str, size: int, room: int) -> int:
    """The size of letters at which a title fits."""
    length = _length(title, BOLD, size)
    return size if length <= room else max(6, int(size * room / length))


@lru_cache(maxsize=64)
def _length(text: str, font: str, size: int) -> float:
    """How long a text is, in [pixel]."""
    with _setting:
        return _font(font, size).getlength(text)


@lru_cache(maxsize=64)  # frames follow each other within a tenth of a second
def _words(
    text: str,
    font: str,
    size: int,
    place: tuple[float, float],
    anchor: str,
    page: tuple[int, int],
    halo: int = 0,
    mark: Mark = lambda *_: None,
) -> Words:
    """Words in a font, anchored at a place of a page, width and height in [pixel].

    With a halo in [pixel] the letters are wider by so much on all sides.
    """
    covered = Image.new("L", page)
    with _setting:
        pen = ImageDraw.Draw(covered)
        mark(pen, halo)
        pen.text(place, text, 255, _font(font, size), anchor=anchor, stroke_width=halo)
    left, top, right, bottom = covered.getbbox() or (0, 0, 0, 0)
    return Words(covered.crop((left, top, right, bottom)), left, top)


def heading(height: int) -> int:
    """Number of rows at the top of a picture reserved for title and time stamp."""
    return 3 * _sizes(height)[0]


def label(image: Bytes, text: str) -> None:
    """Write a word at the upper left of an image (h, w, 3)."""
    height, width = image.shape[:2]
    size = max(9, round(height / 14))
    _words(text, PLAIN, size, (6, 5), "la", (width, height)).on(image, STAMP)


def caption_size(height: int) -> int:
    """Font size of a word in a picture of a height, in [pixel]."""
    return max(9, round(height / 42))


def caption(
    text: str,
    place: tuple[float, float],
    page: tuple[int, int],
    mark: Mark = lambda *_: None,
) -> tuple[Words, Words] | None:
    """A word whose foot is at a place of a page, and what surrounds its letters.

    Args:
        place: Column and row in [pixel].
        page: Width and height in [pixel].
        mark: Draws something with it, given how much wider than usual, in [pixel].

    Returns:
        The letters and their surroundings; None where they would leave the page.
    """
    size = caption_size(page[1])
    inner, outer = (_words(text, BOLD, size, place, "ms", page, k, mark) for k in (0, HALO))
    left, top, right, bottom = outer.box
    inside = min(left, top) > 0 and right < page[0] and bottom < page[1]
    return (inner, outer) if inside else None


@lru_cache(maxsize=256)  # of a machine's frames, in every picture
def name_tag(text: str, height: int) -> tuple[Words, Words]:
    """A name for a picture of a height, and what surrounds its letters; its foot is at (0, 0)."""
    size = caption_size(height)
    middle, page = size * (len(text) + 2), (2 * size * (len(text) + 2), 3 * size)
    inner, outer = (
        _words(text, BOLD, size, (middle, 2 * size), "ms", page, halo) for halo in (0, HALO)
    )
    return inner.moved(-middle, -2 * size), outer.moved(-middle, -2 * size)


def _sizes(height: int) -> tuple[int, int]:
    """Font size and distance from the edge, in [pixel]."""
    size = max(10, round(height / 33))
    return size, round(0.8 * size)


def time_stamp(time: float, speed: float = 1.0) -> str:
    """The motion's time, and the film's speed if it is not real time."""
    pace = "" if speed == 1.0 else f"   {float(f'{speed:.3g}'):g}x"
    return f"t = {time:.1f} s{pace}"


@lru_cache
def _font(name: str, size: int) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(FONTS / name, size)
