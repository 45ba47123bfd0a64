"""A flooded cave with a chamber at its end, and two pipes that somebody laid through it.

cave.ply, z up, [m]: a room (faces inward, negative volume), closed at both ends. Its centreline
is ``centreline(s)``, s in [m] along it; straight pieces and arcs of radius 6.5 m:

| s           | where (x, y, z)                   | heading (x, y, z)    | what                    |
|-------------|-----------------------------------|----------------------|-------------------------|
| -1.6        | (0.4, 3, -4)                      |                      | the rock behind         |
| 0 to 6      | (2, 3, -4) to (8, 3, -4)          | (1, 0, 0)            | straight; a start       |
| 6 to 15.4   | to (14.48, 8.29, -6.05)           | (0.13, 0.92, -0.36)  | to the left and down    |
| 15.4        |                                   |                      | the pipes cross         |
| 15.4 to 27.2| to (23.29, 13.34, -7.51)          | (0.93, -0.31, 0.18)  | to the right and up     |
| 23          | (19.18, 13.43, -7.80)             | (0.96, 0.27, -0.05)  | the throat, 1.2 m       |
| 27.2 to 31.2| to (27.21, 13.25, -7.10)          | (0.96, 0.27, 0.01)   | to the left, level      |
| 34.1        | (30.00, 14.02, -7.06)             | (0.96, 0.27, 0.01)   | the chamber's middle    |
| 37.6        | (33.38, 14.95, -7.01)             |                      | the rock in front       |

The free radius (distance from the centreline to the rock) is at least ``FREE`` outside the throat
and ``THROAT`` in it, 3.2 m in the middle of the chamber; the scripts check this.

pipes.stl, z up, [m]: two pipes of 0.56 m diameter across the tunnel, 0.9 m apart along it. They
lie a little above the centreline: a ball of diameter ``PASSAGE`` passes below them, above them
remain 0.7 m.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import trimesh
from solids import Array, Solid, join, loft, turned

FREE, THROAT, PASSAGE = 1.35, 1.2, 1.2  # [m]
BACK, CHAMBER, END = -1.6, 34.1, 37.6  # [m] along the centreline: ends, and the chamber's middle
NARROW = 23.0  # [m] along the centreline: the throat
LAID = ((14.95, 0.4), (15.85, 0.3))  # [m] along and above the centreline: the pipes
PIPE_RADIUS = 0.28  # [m]
ROUGHNESS = 0.24  # [m] that the rock departs from a smooth tunnel at most
RINGS, SECTIONS = 460, 96


class Piece(NamedTuple):
    """A straight line or an arc: its length in [m], and how far it turns in [rad]."""

    length: float
    left: float
    up: float


START = np.array([2.0, 3.0, -4.0])
PIECES = (
    Piece(6.0, 0.0, 0.0),
    Piece(9.4, 1.34, -0.52),
    Piece(11.8, -1.64, 0.75),
    Piece(4.0, 0.58, -0.20),
    Piece(6.4, 0.0, 0.0),
)


def centreline(s: float) -> tuple[Array, Array]:
    """Return a point of the tunnel's middle (3,) in [m] and its heading, a unit vector (3,).

    Args:
        s: Distance along the line from (2, 3, -4), in [m]; negative behind it.
    """
    point, axes = frame(s)
    return point, axes[:, 0]


def frame(s: float) -> tuple[Array, Array]:
    """Return a point (3,) and axes (3, 3), whose columns point ahead, to the left and up."""
    point, axes = START, np.eye(3)
    for piece in PIECES[:-1]:
        if s <= piece.length:
            return _advance(point, axes, piece, s)
        point, axes = _advance(point, axes, piece, piece.length)
        s -= piece.length
    return _advance(point, axes, PIECES[-1], s)


def _advance(point: Array, axes: Array, piece: Piece, s: float) -> tuple[Array, Array]:
    """Follow an arc: all turns of a piece are about one axis of the moving frame."""
    curvature = float(np.hypot(piece.left, piece.up)) / piece.length
    if curvature == 0.0:
        return point + s * axes[:, 0], axes
    inward = np.array([0.0, piece.left, piece.up]) / (curvature * piece.length)
    angle = curvature * s
    ahead = np.array([1.0, 0.0, 0.0])
    step = (np.sin(angle) * ahead + (1.0 - np.cos(angle)) * inward) / curvature
    tangent = np.cos(angle) * ahead + np.sin(angle) * inward
    normal = np.cos(angle) * inward - np.sin(angle) * ahead
    axis = np.cross(ahead, inward)
    turn = np.outer(tangent, ahead) + np.outer(normal, inward) + np.outer(axis, axis)
    return point + axes @ step, axes @ turn


def radius(s: Array) -> Array:
    """Return the radius of the smooth tunnel in [m]: a tube with a throat, and a ball."""
    tunnel = 1.6 - 0.34 * _throat(s)
    back = np.sqrt(np.clip(1.6**2 - np.minimum(s, 0.0) ** 2, 0.0, None)) / 1.6
    ball = np.sqrt(np.clip(3.5**2 - (s - CHAMBER) ** 2, 0.0, None))
    open_end = np.where(s < CHAMBER, tunnel, 0.0)
    return np.asarray(back * (open_end**6 + ball**6) ** (1 / 6))


def roughness(points: Array) -> Array:
    """Return smooth noise at points (n, 3), between -1 and 1: waves in many directions."""
    total = np.zeros(len(points))
    for k in range(40):
        height, turn = 1.0 - 2.0 * (k + 0.5) / 40, 2.399963 * 7 * k  # the golden angle spreads them
        across = np.sqrt(1.0 - height**2)
        direction = np.array([across * np.cos(turn), across * np.sin(turn), height])
        wavelength = 4.0 * 0.94**k
        total += wavelength**0.8 * np.sin(2 * np.pi / wavelength * points @ direction + 1.7 * k**2)
    return np.tanh(0.11 * total)


def cave() -> Solid:
    """Return the rock's inner surface."""
    s = _stations()
    turn = 2 * np.pi * np.arange(SECTIONS) / SECTIONS
    spokes = np.stack([0 * turn, np.cos(turn), np.sin(turn)])
    frames = [frame(float(a)) for a in s]
    middle, rays = np.stack([p for p, _ in frames]), np.stack([(R @ spokes).T for _, R in frames])
    smooth = middle[:, None] + radius(s)[:, None, None] * rays
    bumps = roughness(smooth.reshape(-1, 3)).reshape(len(s), SECTIONS)
    amplitude = ROUGHNESS * np.minimum(1.0, radius(s)) * (1.0 - 0.85 * _throat(s))
    rock = loft(smooth + (amplitude[:, None] * bumps)[..., None] * rays).inside_out()
    _require_space(rock)
    return rock


def pipes() -> Solid:
    """Return two pipes with flanges; their ends lie in the rock."""
    return join([_pipe(s, above) for s, above in LAID])


def free_radius(rock: Solid, point: Array) -> float:
    """Return the distance from a point (3,) to the rock in [m]; up to 4 m."""
    triangles = rock.vertices[rock.faces]
    near = triangles[np.linalg.norm(triangles - point, axis=2).min(axis=1) < 4.5]
    closest = trimesh.triangles.closest_point(near, np.broadcast_to(point, (len(near), 3)))
    return float(np.linalg.norm(closest - point, axis=1).min(initial=4.0))


def _throat(s: Array) -> Array:
    return np.asarray(np.exp(-(((s - NARROW) / 1.5) ** 2)))


def _stations() -> Array:
    """Return where the rings stand: evenly, but denser where the ends close."""
    back = BACK * np.cos(np.linspace(0.0, np.pi / 2, 24))
    front = CHAMBER + (END - CHAMBER) * np.sin(np.linspace(0.0, np.pi / 2, 48))
    return np.concatenate([back, np.linspace(0.0, CHAMBER, RINGS - 70)[1:-1], front])


def _pipe(s: float, above: float) -> Solid:
    """Lay a level pipe across the tunnel, ``above`` its centreline; [m]."""
    point, (ahead, across, up) = frame(s)[0], _level(s)
    straight = turned(_half_pipe(-1.0) + _half_pipe(1.0)[::-1], sections=40)
    return Solid(
        straight.vertices @ np.stack([up, ahead, across]) + point + above * up, straight.faces
    )


def _half_pipe(side: float) -> list[tuple[float, float]]:
    """Return (radius, height) from a hollow end to the middle, with flanges on the way; [m]."""
    wall, flange = PIPE_RADIUS, PIPE_RADIUS + 0.08
    profile = [(0.0, 2.9), (wall - 0.05, 2.9), (wall - 0.05, 3.2), (wall, 3.2)]
    for middle in (2.4, 0.8):
        profile += [(wall, middle + 0.05), (flange, middle + 0.05)]
        profile += [(flange, middle - 0.05), (wall, middle - 0.05)]
    return [(radius, side * height) for radius, height in profile]


def _level(s: float) -> Array:
    """Return unit vectors ahead, across on the level, and up at right angles to both, (3, 3)."""
    ahead = centreline(s)[1]
    across = np.cross([0.0, 0.0, 1.0], ahead)
    across /= np.linalg.norm(across)
    return np.stack([ahead, across, np.cross(ahead, across)])


def _require_space(rock: Solid) -> None:
    for s in np.arange(0.0, CHAMBER, 0.25):
        _require(rock, centreline(s)[0], FREE if abs(s - NARROW) > 3.0 else THROAT)
    for s, above in LAID:
        middle = above - PIPE_RADIUS - PASSAGE / 2
        _require(rock, centreline(s)[0] + middle * _level(s)[2], PASSAGE / 2)


def _require(rock: Solid, point: Array, promised: float) -> None:
    free = free_radius(rock, point)
    if free < promised:
        raise ValueError(f"At {point.round(2)} the rock is {free:.3f} m away, not {promised} m.")


MESHES = {"cave.ply": cave, "pipes.stl": pipes}
