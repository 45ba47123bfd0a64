"""Solids as triangles: blocks, turned parts, tubes and lofts, all closed and facing outward."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from files import DECIMALS, encode
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Faces = NDArray[np.int64]
Range = tuple[float, float]


@dataclass(frozen=True, eq=False)
class Solid:
    """Closed surfaces, which may overlap.

    Args:
        vertices: Points in [m], shape (n, 3).
        faces: Three vertices each, counterclockwise seen from outside, shape (m, 3).
    """

    vertices: Array
    faces: Faces

    def volume(self) -> float:
        """Return the signed volume in [m³]; overlaps count twice, rooms count negative."""
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0, yaw: float = 0.0) -> Solid:
        """Turn by ``yaw`` in [rad] about the z axis, then shift; [m]."""
        c, s = np.cos(yaw), np.sin(yaw)
        turned = self.vertices @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        return Solid(turned + np.array([x, y, z]), self.faces)

    def along(self, axis: str) -> Solid:
        """Turn a solid that was drawn along z so that it lies along ``axis``."""
        order = {"x": [2, 0, 1], "y": [1, 2, 0], "z": [0, 1, 2]}[axis]
        return Solid(self.vertices[:, order], self.faces)

    def scaled(self, factor: float) -> Solid:
        """Change the size, or the unit of length."""
        return Solid(factor * self.vertices, self.faces)

    def inside_out(self) -> Solid:
        """Turn the faces round: a solid becomes a room."""
        return Solid(self.vertices, self.faces[:, ::-1])

    def with_y_up(self) -> Solid:
        """Change to axes of which y points up, as many drawing programs have them."""
        x, y, z = self.vertices.T
        return Solid(np.stack([x, z, -y], axis=1), self.faces)

    def encoded(self, suffix: str) -> bytes:
        """Return the bytes of a .stl, .ply, .obj or .glb file."""
        return encode(self.vertices, self.faces, suffix)

    def export(self, path: Path) -> None:
        """Write a mesh file; the suffix of its name says which format."""
        path.write_bytes(self.encoded(path.suffix))


def join(parts: Iterable[Solid]) -> Solid:
    """Put several solids into one mesh."""
    solids = list(parts)
    first = np.cumsum([0, *(len(part.vertices) for part in solids)])
    faces = [part.faces + n for part, n in zip(solids, first, strict=False)]
    return Solid(np.concatenate([part.vertices for part in solids]), np.concatenate(faces))


def loft(rings: ArrayLike, tips: ArrayLike | None = None) -> Solid:
    """Skin a row of rings and close both ends with a fan of triangles.

    Args:
        rings: Points in [m], shape (rings, points of a ring, 3). Equal points become one, so a
            ring may shrink to a point.
        tips: Where the two fans meet, shape (2, 3); by default in the middle of the end rings,
            from which all of a convex ring is seen.
    """
    points = np.asarray(rings, dtype=float)
    n, k = points.shape[:2]
    here = np.arange(n * k).reshape(n, k)
    there = np.roll(here, -1, axis=1)
    a, b, c, d = (side.ravel() for side in (here[:-1], there[:-1], there[1:], here[1:]))
    fans = _fan(here[0], n * k)[:, ::-1], _fan(here[-1], n * k + 1)
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1), *fans])
    ends = points[[0, -1]].mean(axis=1) if tips is None else np.asarray(tips, dtype=float)
    return _outward(*_welded(np.concatenate([points.reshape(-1, 3), ends]), faces))


def block(x: Range, y: Range, z: Range, bevel: float = 0.0) -> Solid:
    """Make a box from its limits along each axis, its edges cut off by ``bevel``; [m]."""
    rings = [_octagon(x, y, bevel, inset, height) for inset, height in _steps(z, bevel)]
    return loft(rings, [rings[0][0], rings[-1][0]])


def box(size: Sequence[float], at: Sequence[float], bevel: float = 0.0) -> Solid:
    """Make a box from its full edges (3,) and the middle of its underside (3,); [m]."""
    (a, b, c), (x, y, z) = size, at
    return block((x - a / 2, x + a / 2), (y - b / 2, y + b / 2), (z, z + c), bevel)


def turned(profile: Sequence[tuple[float, float]], sections: int = 32) -> Solid:
    """Turn a profile of (radius, height) about the z axis; [m]."""
    circle = _circle(sections)
    rings = [np.column_stack([r * circle, np.full(sections, z)]) for r, z in profile]
    return loft(rings)


def cylinder(radius: float, z: Range, sections: int = 32, bevel: float = 0.0) -> Solid:
    """Make an upright cylinder on the z axis, its rims cut off by ``bevel``; [m]."""
    return turned([(radius - inset, height) for inset, height in _steps(z, bevel)], sections)


def vessel(radius: float, z: Range, rise: float, sections: int = 32) -> Solid:
    """Make an upright tank whose ends are domes that ``rise`` by that much; [m]."""
    angle = np.linspace(0.0, np.pi / 2, 9)
    dome = [(radius * np.cos(a), rise * np.sin(a)) for a in angle]
    upper = [(r, z[1] - rise + h) for r, h in dome]
    return turned([*[(r, z[0] + rise - h) for r, h in dome[::-1]], *upper], sections)


def tube(path: ArrayLike, radius: float, sections: int = 16) -> Solid:
    """Sweep a disc along a path of shape (n, 3) in [m]; bends must be wider than the disc."""
    points = np.asarray(path, dtype=float)
    across, beside = _frames(points)
    circle = radius * _circle(sections)
    rim = circle[:, :1, None] * across[:, None, None] + circle[:, 1:, None] * beside[:, None, None]
    return loft(points[:, None] + rim.reshape(len(points), sections, 3))


def bent(corners: ArrayLike, radius: float, steps: int = 8) -> Array:
    """Round the corners of a polyline of shape (n, 3) with arcs of one radius; [m]."""
    points = np.asarray(corners, dtype=float)
    arcs = [
        _arc(a, b, c, radius, steps)
        for a, b, c in zip(points[:-2], points[1:-1], points[2:], strict=True)
    ]
    return np.concatenate([points[:1], *arcs, points[-1:]])


def ramp(x: ArrayLike, height: ArrayLike, y: Range) -> Solid:
    """Make a solid that stands on the ground under a curve of heights over x; [m]."""
    return loft(
        [
            [(a, y[0], 0), (a, y[1], 0), (a, y[1], h), (a, y[0], h)]
            for a, h in zip(np.asarray(x), np.asarray(height), strict=True)
        ]
    )


def _fan(ring: Faces, middle: int) -> Faces:
    return np.stack([ring, np.roll(ring, -1), np.full(len(ring), middle)], axis=1)


def _welded(vertices: Array, faces: Faces) -> tuple[Array, Faces]:
    """Make equal points one vertex and drop the faces that this leaves without area."""
    _, first, index = np.unique(
        vertices.round(DECIMALS + 2) + 0.0, axis=0, return_index=True, return_inverse=True
    )
    merged = index.reshape(-1)[faces]
    a, b, c = merged.T
    merged = merged[(a != b) & (b != c) & (c != a)]
    used, merged = np.unique(merged, return_inverse=True)
    return vertices[first[used]], merged.reshape(-1, 3)


def _outward(vertices: Array, faces: Faces) -> Solid:
    solid = Solid(vertices, faces)
    return solid if solid.volume() > 0.0 else solid.inside_out()


def _steps(z: Range, bevel: float) -> list[tuple[float, float]]:
    low, high = z
    return [(bevel, low), (0.0, low + bevel), (0.0, high - bevel), (bevel, high)]


def _octagon(x: Range, y: Range, bevel: float, inset: float, height: float) -> list[list[float]]:
    """Return a rectangle without its corners; with a bevel of 0 they coincide in pairs."""
    (x0, x1), (y0, y1) = (x[0] + inset, x[1] - inset), (y[0] + inset, y[1] - inset)
    b = bevel
    corners = [(x0 + b, y0), (x1 - b, y0), (x1, y0 + b), (x1, y1 - b)]
    corners += [(x1 - b, y1), (x0 + b, y1), (x0, y1 - b), (x0, y0 + b)]
    return [[*corner, height] for corner in corners]


def _circle(sections: int) -> Array:
    turn = 2.0 * np.pi * np.arange(sections) / sections
    return np.stack([np.cos(turn), np.sin(turn)], axis=1)


def _frames(path: Array) -> tuple[Array, Array]:
    """Return two unit vectors across a path at each point, carried along without twist."""
    step = np.diff(path, axis=0)
    step /= np.linalg.norm(step, axis=1, keepdims=True)
    tangent = np.concatenate([step[:1], step[:-1] + step[1:], step[-1:]])
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    across = np.empty_like(path)
    carried = np.eye(3)[np.argmin(np.abs(tangent[0]))]
    for i, t in enumerate(tangent):
        carried = carried - (carried @ t) * t
        carried = across[i] = carried / np.linalg.norm(carried)
    return across, np.cross(tangent, across)


def _arc(a: Array, b: Array, c: Array, radius: float, steps: int) -> Array:
    """Return points on the arc that touches the lines from b to a and from b to c."""
    u, v = (a - b) / np.linalg.norm(a - b), (c - b) / np.linalg.norm(c - b)
    half = 0.5 * np.arccos(np.clip(u @ v, -1.0, 1.0))
    middle = b + radius / np.sin(half) * (u + v) / np.linalg.norm(u + v)
    outward, along = (b - middle) * np.sin(half), radius * (v - u) / np.linalg.norm(v - u)
    angle = np.linspace(half - np.pi / 2, np.pi / 2 - half, steps + 1)[:, None]
    outward *= radius / np.linalg.norm(outward)
    return np.asarray(middle + np.cos(angle) * outward + np.sin(angle) * along)
