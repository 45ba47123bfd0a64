"""Rasterise triangles with a depth buffer: the nearest wins, in any drawing order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.numerics.arrays import Array, Bytes
from kinolab.numerics.jit import allocating_kernel

Box: TypeAlias = tuple[int, int, int, int]  # left, top, right, bottom in [pixel], half open

COUNTS = np.array([bin(byte).count("1") for byte in range(256)], dtype=np.uint8)  # of bits
OTHER, GROUND = 0, 1  # kind of a pixel; bit 2 << k marks it as shadowed from lamp k
REVEALED = 128  # bit of a pixel at which something hidden shows through


@dataclass(frozen=True, eq=False)
class Canvas:
    """Pixels with depth, and flags for ground and shadows.

    Args:
        color: RGB, shape (h, w, 3).
        nearness: 1 / depth in [1/m], shape (h, w); 0 is infinitely far.
        kind: ``OTHER`` or ``GROUND`` and bits of shadowing lamps, shape (h, w).
    """

    color: Bytes
    nearness: NDArray[np.float32]
    kind: Bytes

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in [pixel]."""
        return self.kind.shape[1], self.kind.shape[0]

    def part(self, box: Box) -> Canvas:
        """A copy of the pixels inside a box."""
        left, top, right, bottom = box
        window = (slice(top, bottom), slice(left, right))
        return Canvas(
            self.color[window].copy(), self.nearness[window].copy(), self.kind[window].copy()
        )


def blank(size: tuple[int, int], color: ArrayLike) -> Canvas:
    """An empty canvas of one colour (r, g, b) in 0..255."""
    canvas = empty(size)
    canvas.color[:] = np.asarray(color, dtype=np.uint8)
    canvas.nearness[:] = 0.0
    canvas.kind[:] = OTHER
    return canvas


def empty(size: tuple[int, int]) -> Canvas:
    """A canvas whose pixels are still to be written."""
    width, height = size
    return Canvas(
        np.empty((height, width, 3), dtype=np.uint8),
        np.empty((height, width), dtype=np.float32),
        np.empty((height, width), dtype=np.uint8),
    )


@dataclass(frozen=True, eq=False)
class Facets:
    """Coloured triangles in picture coordinates.

    Args:
        corners: Column and row in [pixel] and nearness in [1/m], shape (m, 3, 3).
        colors: RGB in 0..255, shape (m, 3).
    """

    corners: Array
    colors: Bytes

    def __add__(self, other: Facets) -> Facets:
        """Concatenate, the others after these."""
        return Facets(
            np.concatenate([self.corners, other.corners]),
            np.concatenate([self.colors, other.colors]),
        )


NO_FACETS = Facets(np.zeros((0, 3, 3)), np.zeros((0, 3), dtype=np.uint8))


def draw(canvas: Canvas, facets: Facets, kind: int = OTHER) -> None:
    """Draw triangles where they are nearer than the content of the canvas.

    A pixel belongs to a triangle that contains its centre. Triangles that share an edge neither
    overlap nor leave a gap. Triangles with a corner behind the camera are left out.
    """
    _draw(canvas.color, canvas.nearness, canvas.kind, facets.corners, facets.colors, kind)


def reveal(canvas: Canvas, facets: Facets) -> None:
    """Mix the colour of triangles with what hides them; at each pixel that of the first one."""
    _reveal(canvas.color, canvas.nearness, canvas.kind, facets.corners, facets.colors)


def paint_ground(canvas: Canvas, facets: Facets) -> None:
    """Colour the ground inside triangles, without depth test; the last one wins."""
    _paint(canvas.color, canvas.kind, facets.corners, facets.colors)


def darken(canvas: Canvas, shadows: Sequence[Array], factor: Array) -> None:
    """Darken the ground inside shadow triangles, each pixel once per lamp.

    Args:
        canvas: The canvas.
        shadows: For each lamp, of 6 at most, its triangles: column and row in [pixel], shape
            (m, 3, 3).
        factor: On red, green and blue per shadowing lamp, in [0, 1], shape (3,).
    """
    before = canvas.kind.copy()
    for lamp, corners in enumerate(shadows):
        _hide(canvas.kind, corners, 2 << lamp)
    _dim(canvas.color, before, canvas.kind, _dimmed(len(shadows), tuple(factor)))


@lru_cache
def _dimmed(lamps: int, factor: tuple[float, ...]) -> Bytes:
    """What is left of a channel by number of shadowing lamps, shape (lamps + 1, 256, 3)."""
    hidden = np.arange(lamps + 1)[:, None, None]
    left = np.arange(256)[None, :, None] * np.asarray(factor) ** hidden
    return (left + 0.5).astype(np.uint8)


def extent(corners: Array, size: tuple[int, int], multiple: int = 1) -> Box:
    """The smallest box around triangles (m, 3, 3) in [pixel], sides at multiples of a number."""
    left, top, right, bottom = _extent(corners.reshape(-1, 3))
    if left > right:
        return 0, 0, 0, 0
    limit = np.array(size)
    low = np.clip(np.floor([left, top]), 0, limit) // multiple * multiple
    high = np.clip(np.ceil([right, bottom]), 0, limit)
    high = -(-high // multiple) * multiple
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


def average(pixels: Bytes, block: int) -> Bytes:
    """The mean of every ``block`` x ``block`` pixels of shape (h, w, 3), both its multiples."""
    height, width = pixels.shape[0] // block, pixels.shape[1] // block
    out = np.empty((height, 3 * width), dtype=np.uint8)
    _average(pixels.reshape(len(pixels), 3 * pixels.shape[1]), block, out)
    return out.reshape(height, width, 3)


@allocating_kernel  # type: ignore[untyped-decorator]
def _extent(points: Array) -> tuple[float, float, float, float]:
    """Left, top, right and bottom of points in front of the camera; left > right if none is."""
    left, top, right, bottom = np.inf, np.inf, -np.inf, -np.inf
    for k in range(points.shape[0]):
        x, y = points[k, 0], points[k, 1]
        if np.isfinite(x) and np.isfinite(y) and np.isfinite(points[k, 2]) and points[k, 2] > 0.0:
            left, top = min(left, x), min(top, y)
            right, bottom = max(right, x), max(bottom, y)
    return left, top, right, bottom


@allocating_kernel  # type: ignore[untyped-decorator]
def _lines(tri: Array, lines: Array) -> None:
    """Write a triangle's edges: first and last row, first column, columns per row."""
    for i in range(3):
        a, b = tri[i], tri[0 if i == 2 else i + 1]
        lines[i, 0], lines[i, 1], lines[i, 2] = a[1], b[1], a[0]
        lines[i, 3] = (b[0] - a[0]) / (b[1] - a[1]) if a[1] != b[1] else 0.0


@allocating_kernel  # type: ignore[untyped-decorator]
def _span(lines: Array, row: float) -> tuple[float, float]:
    """The interval in which a horizontal line crosses a triangle; empty if low > high."""
    low, high = np.inf, -np.inf
    for i in range(3):
        if (lines[i, 0] <= row) != (lines[i, 1] <= row):
            x = lines[i, 2] + (row - lines[i, 0]) * lines[i, 3]
            low, high = min(low, x), max(high, x)
    return low, high


@allocating_kernel  # type: ignore[untyped-decorator]
def _rows(tri: Array, height: int) -> tuple[int, int]:
    """The rows whose centres a triangle may cover, half open; none if it cannot be drawn."""
    for i in range(3):
        if not (np.isfinite(tri[i, 0]) and np.isfinite(tri[i, 1]) and tri[i, 2] > 0.0):
            return 0, 0
    top = min(tri[0, 1], tri[1, 1], tri[2, 1])
    bottom = max(tri[0, 1], tri[1, 1], tri[2, 1])
    rows: tuple[int, int] = _within(top, bottom, height)
    return rows


@allocating_kernel  # type: ignore[untyped-decorator]
def _within(low: float, high: float, count: int) -> tuple[int, int]:
    """The rows or columns, of so many, whose centres lie in [low, high)."""
    first = max(0.0, np.ceil(low - 0.5))
    last = min(float(count), np.ceil(high - 0.5))
    if first >= last:
        return 0, 0
    return int(first), int(last)


@allocating_kernel  # type: ignore[untyped-decorator]
def _draw(
    color: Bytes,
    nearness: NDArray[np.float32],
    kind: Bytes,
    corners: Array,
    colors: Bytes,
    tag: int,
) -> None:
    """Draw triangles with depth test.

    Args:
        color, nearness, kind: Of ``Canvas``, (h, w, 3), (h, w) and (h, w); written.
        corners, colors: Of ``Facets``, (m, 3, 3) and (m, 3).
        tag: The kind that is written.
    """
    height, width = nearness.shape
    lines = np.empty((3, 4))
    for k in range(corners.shape[0]):
        tri = corners[k]
        ax, ay = tri[1, 0] - tri[0, 0], tri[1, 1] - tri[0, 1]
        bx, by = tri[2, 0] - tri[0, 0], tri[2, 1] - tri[0, 1]
        area = ax * by - bx * ay
        if area == 0.0:
            continue
        aw, bw = tri[1, 2] - tri[0, 2], tri[2, 2] - tri[0, 2]
        slope_x, slope_y = (aw * by - bw * ay) / area, (ax * bw - bx * aw) / area
        # Rounding must not extrapolate an edge-on face beyond its own corners.
        farthest = min(tri[0, 2], tri[1, 2], tri[2, 2])
        nearest = max(tri[0, 2], tri[1, 2], tri[2, 2])
        first, last = _rows(tri, height)
        _lines(tri, lines)
        for i in range(first, last):
            low, high = _span(lines, i + 0.5)
            left, right = _within(low, high, width)
            start = tri[0, 2] + slope_y * (i + 0.5 - tri[0, 1]) + slope_x * (0.5 - tri[0, 0])
            for j in range(left, right):
                near = np.float32(min(max(start + slope_x * j, farthest), nearest))
                if near > nearness[i, j]:
                    nearness[i, j] = near
                    kind[i, j] = tag
                    color[i, j, 0] = colors[k, 0]
                    color[i, j, 1] = colors[k, 1]
                    color[i, j, 2] = colors[k, 2]


@allocating_kernel  # type: ignore[untyped-decorator]
def _reveal(
    color: Bytes, nearness: NDArray[np.float32], kind: Bytes, corners: Array, colors: Bytes
) -> None:
    """Mix hidden triangles with what hides them.

    Args:
        color, nearness, kind: Of ``Canvas``, (h, w, 3), (h, w) and (h, w); the nearness is read.
        corners, colors: Of ``Facets``, (m, 3, 3) and (m, 3).
    """
    height, width = nearness.shape
    lines = np.empty((3, 4))
    for k in range(corners.shape[0]):
        farthest = min(corners[k, 0, 2], corners[k, 1, 2], corners[k, 2, 2])
        first, last = _rows(corners[k], height)
        _lines(corners[k], lines)
        for i in range(first, last):
            low, high = _span(lines, i + 0.5)
            left, right = _within(low, high, width)
            for j in range(left, right):
                if nearness[i, j] > farthest and not kind[i, j] & REVEALED:
                    kind[i, j] |= np.uint8(REVEALED)
                    for c in range(3):
                        color[i, j, c] = (color[i, j, c] + np.uint16(colors[k, c])) >> 1


@allocating_kernel  # type: ignore[untyped-decorator]
def _paint(color: Bytes, kind: Bytes, corners: Array, colors: Bytes) -> None:
    height, width = kind.shape
    lines = np.empty((3, 4))
    for k in range(corners.shape[0]):
        first, last = _rows(corners[k], height)
        _lines(corners[k], lines)
        for i in range(first, last):
            low, high = _span(lines, i + 0.5)
            left, right = _within(low, high, width)
            for j in range(left, right):
                if kind[i, j] & GROUND:
                    for c in range(3):
                        color[i, j, c] = colors[k, c]


@allocating_kernel  # type: ignore[untyped-decorator]
def _hide(kind: Bytes, corners: Array, bit: int) -> None:
    """Mark the ground inside triangles, branch-free so that it is vectorised."""
    height, width = kind.shape
    mark, lines = np.uint8(bit), np.empty((3, 4))
    for k in range(corners.shape[0]):
        first, last = _rows(corners[k], height)
        _lines(corners[k], lines)
        for i in range(first, last):
            low, high = _span(lines, i + 0.5)
            left, right = _within(low, high, width)
            part = kind[i, left:right]
            for j in range(part.shape[0]):
                part[j] |= (part[j] & np.uint8(GROUND)) * mark


@allocating_kernel  # type: ignore[untyped-decorator]
def _dim(color: Bytes, before: Bytes, after: Bytes, left: Bytes) -> None:
    """Darken each pixel by its number of newly shadowing lamps; ``left`` is the result."""
    for i in range(before.shape[0]):
        for j in range(before.shape[1]):
            new = before[i, j] ^ after[i, j]
            if new:
                for c in range(3):
                    color[i, j, c] = left[COUNTS[new], color[i, j, c], c]


@allocating_kernel  # type: ignore[untyped-decorator]
def _average(pixels: Bytes, block: int, out: Bytes) -> None:
    """Take means; red, green and blue follow each other in a row, so that sums are vectorised."""
    count = block * block
    share = (1 << 16) // count + 1  # of 2^16: exact for what blocks up to 8 x 8 add up to
    sums = np.empty(pixels.shape[1], dtype=np.uint16)  # of a column in a row of blocks
    for i in range(out.shape[0]):
        sums[:] = 0
        for a in range(block):
            row = pixels[i * block + a]
            for k in range(sums.shape[0]):
                sums[k] += row[k]
        for j in range(out.shape[1] // 3):
            for c in range(3):
                total = count // 2
                for b in range(block):
                    total += sums[3 * (j * block + b) + c]
                out[i, 3 * j + c] = total * share >> 16
