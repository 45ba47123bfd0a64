"""Title, time stamp and labels on images."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

Bytes: TypeAlias = NDArray[np.uint8]

TITLE, STAMP = (38, 42, 50), (96, 100, 108)
FONTS = Path(__file__).parent / "fonts"  # DejaVu Sans, which has letters for most languages


def lettered(image: Bytes, title: str, stamp: str) -> Bytes:
    """A copy of an image (h, w, 3) with a title at the upper left and a time stamp at the right."""
    height, width = image.shape[:2]
    size, edge = _sizes(height)
    strip = min(height, heading(height))
    normal = _font("DejaVuSans.ttf", size)
    room = width - 3 * edge - normal.getlength(stamp)
    sheet = Image.fromarray(image[:strip])
    sheet.paste(TITLE, (0, 0), _title(title, size, edge, int(room), (width, strip)))
    pencil = ImageDraw.Draw(sheet)
    pencil.text((width - edge, edge), stamp, STAMP, normal, anchor="ra")
    return np.concatenate([np.asarray(sheet), image[strip:]])


@lru_cache(maxsize=64)  # a longer stamp leaves less space
def _title(title: str, size: int, edge: int, room: int, strip: tuple[int, int]) -> Image.Image:
    """Coverage mask of the title in a strip, in smaller letters if it does not fit."""
    length = _font("DejaVuSans-Bold.ttf", size).getlength(title)
    fitting = size if length <= room else max(6, int(size * room / length))
    covered = Image.new("L", strip)
    bold = _font("DejaVuSans-Bold.ttf", fitting)
    ImageDraw.Draw(covered).text((edge, edge), title, 255, bold, anchor="la")
    return covered


def heading(height: int) -> int:
    """Number of rows at the top of a picture reserved for title and time stamp."""
    return 3 * _sizes(height)[0]


def label(image: Bytes, text: str) -> Bytes:
    """A copy of an image (h, w, 3) with a word at the upper left."""
    sheet = Image.fromarray(image)
    font = _font("DejaVuSans.ttf", max(9, round(image.shape[0] / 14)))
    ImageDraw.Draw(sheet).text((6, 5), text, STAMP, font, anchor="la")
    return np.asarray(sheet)


def _sizes(height: int) -> tuple[int, int]:
    """Font size and distance from the edge, in [pixel]."""
    size = max(10, round(height / 33))
    return size, round(0.8 * size)


def time_stamp(time: float, speed: float = 1.0) -> str:
    """The motion's time, and the film's speed if it is not real time."""
    pace = "" if speed == 1.0 else f"   {speed:.3g}x"
    return f"t = {time:.1f} s{pace}"


@lru_cache
def _font(name: str, size: int) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(FONTS / name, size)
