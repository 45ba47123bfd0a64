"""A slot canyon with three bends, a sill, and a rock bridge to fly under.

canyon.ply, z up, [m]: a room (faces inward, negative volume), closed at both ends and overhead,
where the walls lean together. Its floor is level but for the sill. Its middle on the map is
``middle(s)``, s in [m] along it; straight pieces and level arcs:

| s            | where (x, y)               | heading  | what                                   |
|--------------|----------------------------|----------|----------------------------------------|
| -2.2         | (-2.2, 0)                  |          | the rock behind                        |
| 0 to 6       | (0, 0) to (6, 0)           | 0.00 rad | straight; a start                      |
| 6 to 13      | to (11.56, 3.60)           | 1.15 rad | to the left                            |
| 10.5         | (10.10, 1.59)              |          | the sill, 1.3 m high                   |
| 13 to 16     | to (12.78, 6.34)           | 1.15 rad | straight; the narrows                  |
| 16 to 25     | to (20.33, 7.87)           | -0.75 rad| to the right                           |
| 25 to 29     | to (23.26, 5.14)           | -0.75 rad| straight; the bridge at 26.5           |
| 29 to 34     | to (27.91, 4.08)           | 0.30 rad | to the left                            |
| 34 to 38     | to (31.74, 5.26)           | 0.30 rad | straight; a goal                       |
| 40.2         |                            |          | the rock in front                      |

rocks.stl, z up, [m]: the bridge from wall to wall, which fills the canyon above its underside, and
a boulder on the floor. The way ``way(s)`` leads over the sill and under the bridge; along it a
ball of radius ``FREE`` passes, as the scripts check.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from cave import free_radius, roughness
from solids import Array, Solid, join, loft

FREE = 1.25  # [m]
BACK, END, TOP = -2.2, 40.2, 5.6  # [m] along the middle; height of the crack overhead
SILL, NARROWS, BRIDGE = 10.5, 14.5, 26.5  # [m] along the middle
SILL_HEIGHT, UNDERSIDE = 1.3, 2.75  # [m] above the floor
ROUGHNESS = 0.22  # [m] that the rock departs from smooth walls at most
RINGS, SECTIONS = 240, 88


class Piece(NamedTuple):
    """A straight line or a level arc: its length in [m], and how far it turns in [rad]."""

    length: float
    left: float


PIECES = (
    Piece(6.0, 0.0),
    Piece(7.0, 1.15),
    Piece(3.0, 0.0),
    Piece(9.0, -1.9),
    Piece(4.0, 0.0),
    Piece(5.0, 1.05),
    Piece(4.0, 0.0),
)


def middle(s: float) -> tuple[Array, float]:
    """Return a point (2,) of the canyon's middle on the map in [m], and its heading in [rad]."""
    point, heading = np.zeros(2), 0.0
    for piece in PIECES[:-1]:
        if s <= piece.length:
            return _advance(point, heading, piece, s)
        point, heading = _advance(point, heading, piece, piece.length)
        s -= piece.length
    return _advance(point, heading, PIECES[-1], s)


def _advance(point: Array, heading: float, piece: Piece, s: float) -> tuple[Array, float]:
    turn = piece.left * s / piece.length
    chord = s * np.sinc(turn / (2 * np.pi))
    half = heading + turn / 2
    return point + chord * np.array([np.cos(half), np.sin(half)]), heading + turn


def way(s: float) -> Array:
    """Return a point (3,) that has room all round: over the sill, under the bridge; [m]."""
    height = 2.0 + 1.3 * np.exp(-(((s - SILL) / 2.2) ** 2))
    height -= 0.62 * np.exp(-(((s - BRIDGE) / 2.4) ** 2))
    return np.append(middle(s)[0], height)


def canyon() -> Solid:
    """Return the rock's inner surface."""
    s = np.concatenate([np.linspace(BACK, 0.0, 20)[:-1], np.linspace(0.0, 38.0, RINGS)])
    s = np.concatenate([s, np.linspace(38.0, END, 20)[1:]])
    rings = np.stack([_section(float(a)) for a in s])
    inward = np.stack([_spoke(float(a)) for a in s])
    bumps = roughness(0.8 * rings.reshape(-1, 3)).reshape(len(s), SECTIONS)
    amplitude = ROUGHNESS * _opening(s)[:, None] * np.abs(inward[..., :2]).max(axis=-1)
    return loft(rings + (amplitude * bumps)[..., None] * inward).inside_out()


def rocks() -> Solid:
    """Return the bridge and the boulder."""
    bridge, stone = _bridge(), _boulder()
    rock = join([bridge, stone])
    _require_space(canyon(), rock)
    return rock


def _section(s: float) -> Array:
    """Return the outline (SECTIONS, 3) of the canyon across its middle, narrower overhead."""
    place, heading = middle(s)
    left, up = np.array([-np.sin(heading), np.cos(heading), 0.0]), np.array([0.0, 0.0, 1.0])
    turn = 2 * np.pi * np.arange(SECTIONS) / SECTIONS
    across, height = _squared(np.cos(turn)), 0.5 + 0.5 * _squared(np.sin(turn))
    floor = SILL_HEIGHT * np.exp(-(((s - SILL) / 1.3) ** 2))
    z = floor + (TOP - floor) * height
    width = _width(s) * (1.0 - 0.38 * np.clip(z / TOP, 0.0, 1.0) ** 2)
    return np.append(place, 0.0) + (width * across)[:, None] * left + z[:, None] * up


def _squared(component: Array) -> Array:
    """Round off the corners of a square: a superellipse of exponent 5."""
    return np.asarray(np.sign(component) * np.abs(component) ** 0.4)


def _spoke(s: float) -> Array:
    """Return unit vectors (SECTIONS, 3) from the middle of a section to its outline."""
    ring = _section(s)
    rays = ring - ring.mean(axis=0)
    return np.asarray(rays / np.maximum(np.linalg.norm(rays, axis=1, keepdims=True), 1e-9))


def _width(s: float) -> float:
    """Return half the canyon's width at its floor in [m]."""
    narrow = 0.55 * np.exp(-(((s - NARROWS) / 1.8) ** 2))
    return float((2.25 - narrow + 0.25 * np.sin(0.7 * s)) * _opening(np.array(s)))


def _opening(s: Array) -> Array:
    """Return how far open the canyon is near its ends, as a share."""
    back = np.sqrt(np.clip(1.0 - (np.minimum(s, 0.0) / BACK) ** 2, 0.0, 1.0))
    front = np.sqrt(np.clip(1.0 - (np.maximum(s - 38.0, 0.0) / (END - 38.0)) ** 2, 0.0, 1.0))
    return np.asarray(np.maximum(np.minimum(back, front), 0.02))


def _bridge() -> Solid:
    """A block of rock from wall to wall, and up into the crack, with a rough underside."""
    place, heading = middle(BRIDGE)
    ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
    left = np.array([-ahead[1], ahead[0], 0.0])
    across, turn = np.linspace(-2.5, 2.5, 33), 2 * np.pi * np.arange(40) / 40
    middle_height = UNDERSIDE + 1.75 - 0.05 * across**2
    thick = 0.75 + 0.06 * across**2
    rings = [
        np.append(place, 0.0)
        + y * left
        + (t * _squared(np.cos(turn)))[:, None] * ahead
        + (z + 1.7 * _squared(np.sin(turn)))[:, None] * np.array([0.0, 0.0, 1.0])
        for y, z, t in zip(across, middle_height, thick, strict=True)
    ]
    points = np.stack(rings)
    bumps = roughness(points.reshape(-1, 3)).reshape(points.shape[:2])
    rays = points - points.mean(axis=1, keepdims=True)
    return loft(points + 0.12 * bumps[..., None] * rays / 1.7)


def _boulder() -> Solid:
    """A round stone that lies beside the way."""
    place, heading = middle(20.0)
    left = np.array([-np.sin(heading), np.cos(heading)])
    x, y = place + 1.75 * left
    angle = np.linspace(0.0, np.pi, 22)
    turn = 2 * np.pi * np.arange(36) / 36
    rings = np.stack(
        [
            np.column_stack(
                [np.sin(a) * np.cos(turn), np.sin(a) * np.sin(turn), np.full(36, -np.cos(a))]
            )
            for a in angle
        ]
    )
    size = 0.8 + 0.12 * roughness(1.0 * rings.reshape(-1, 3)).reshape(rings.shape[:2])
    size[0], size[-1] = size[0, 0], size[-1, 0]  # a ring that is a point has one radius
    return Solid(*_placed(loft(size[..., None] * rings), (float(x), float(y), 0.35)))


def _placed(solid: Solid, at: tuple[float, float, float]) -> tuple[Array, Array]:
    return solid.vertices + np.array(at), solid.faces


def _require_space(walls: Solid, rock: Solid) -> None:
    for s in np.arange(0.0, 38.0, 0.25):
        point = way(float(s))
        for name, solid in (("the canyon", walls), ("a rock", rock)):
            free = free_radius(solid, point)
            if free < FREE:
                raise ValueError(f"At {point.round(2)} {name} is {free:.3f} m away, not {FREE} m.")


MESHES = {"canyon.ply": canyon, "rocks.stl": rocks}
