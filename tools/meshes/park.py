"""A skate park of 16 m by 12 m: ramps, a bowl, rails and planters to find a way between.

skate_park.ply, z up, [m]. The straight way from (2, 2) to (13.5, 9.5) meets the funbox and then
runs into the bowl. Two ways round the bowl, on either side, are at least 1.8 m wide.

| what               | x            | y            | top  | remark                             |
|--------------------|--------------|--------------|------|------------------------------------|
| start, goal (free) | 2, 13.5      | 2, 9.5       |      | 1.5 m all round                    |
| quarter pipe       | 0.6 to 6.1   | 9.6 to 12.0  | 1.3  | rises toward +y; fence to 2.1      |
| quarter pipe       | 13.8 to 16.0 | 1.2 to 6.0   | 1.1  | rises toward +x; fence to 1.9      |
| funbox             | 3.3 to 7.1   | 2.7 to 5.5   | 0.7  | middle (5.2, 4.1), turned 0.2 rad  |
| bowl               | 7.7 to 11.8  | 4.7 to 9.4   | 1.1  | middle (9.3, 6.9), open to -x -y   |
| spine              | 9.6 to 12.2  | 0.5 to 2.9   | 0.9  | two ramps back to back             |
| bank               | 5.4 to 8.2   | 0.0 to 1.0   | 0.5  | rises toward -y                    |
| rail on posts      | 0.9 to 3.0   | 5.9 to 7.5   | 0.45 |                                    |
| rail on posts      | 7.7 to 10.5  | 11.1 to 11.6 | 0.45 |                                    |
| planters           |              |              | 0.6  | at ``PLANTERS``, with shrubs to 1.4|
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from solids import Array, Range, Solid, bent, cylinder, join, loft, ramp, tube, turned

LIP = 0.02  # [m] height of a ramp's edge
PLANTERS = ((13.2, 0.7), (15.2, 7.4), (5.9, 7.2), (12.4, 11.3), (0.8, 4.4))  # middles (x, y) in [m]


def skate_park() -> Solid:
    """Return all that stands in the park."""
    quarter = np.pi / 2
    return join(
        [
            quarter_pipe(height=1.3, radius=1.8, width=5.5).moved(3.35, 9.65, yaw=quarter),
            quarter_pipe(height=1.1, radius=1.6, width=4.8).moved(13.85, 3.6),
            funbox().moved(5.2, 4.1, yaw=0.2),
            bowl(1.0, 1.1, (-np.pi / 3, 0.72 * np.pi)).moved(9.3, 6.9),
            spine(length=2.4).moved(10.9, 1.7),
            bank(width=2.8).moved(6.8, 1.0, yaw=-quarter),
            rail([(0.9, 5.9), (2.0, 6.5), (3.0, 7.5)]),
            rail([(7.7, 11.5), (10.5, 11.2)]),
            *(planter().moved(x, y) for x, y in PLANTERS),
        ]
    )


def quarter_pipe(height: float, radius: float, width: float) -> Solid:
    """A ramp whose foot lies on the y axis and that rises toward +x, with a deck; [m]."""
    x, h = transition(height, radius)
    deck, half = x[-1] + 0.6, width / 2
    surface = ramp([*x, deck], [*h, height], (-half, half))
    coping = tube([(x[-1], -half, height), (x[-1], half, height)], 0.03)
    return join([surface, coping, _fence((-half + 0.05, half - 0.05), height).moved(deck - 0.06)])


def transition(height: float, radius: float, steps: int = 24) -> tuple[Array, Array]:
    """Return places and heights of a ramp's concave face, an arc that starts on the level; [m]."""
    angle = np.linspace(0.0, np.arccos(1.0 - height / radius), steps + 1)
    return radius * np.sin(angle), np.maximum(radius * (1.0 - np.cos(angle)), LIP)


def funbox() -> Solid:
    """Two curved kickers, a table between them, and a ledge on it, along x; [m]."""
    x, h = transition(0.5, 1.6, 12)
    places, heights = [*(x - x[-1] - 0.5), *(0.5 + x[-1] - x[::-1])], [*h, *h[::-1]]
    ledge = loft(
        [[(x, -0.25, 0.4), (x, 0.25, 0.4), (x, 0.25, 0.7), (x, -0.25, 0.7)] for x in (-0.6, 0.6)]
    )
    return join([ramp(places, heights, (-1.1, 1.1)), ledge])


def spine(length: float) -> Solid:
    """Two ramps back to back whose ridge runs along y, with a coping; [m]."""
    x, h = transition(0.9, 1.3)
    surface = ramp([*(x - 1.3), *(1.3 - x[::-1])], [*h, *h[::-1]], (-length / 2, length / 2))
    pipes = [
        tube([(s * (x[-1] - 1.3), -length / 2, 0.9), (s * (x[-1] - 1.3), length / 2, 0.9)], 0.03)
        for s in (-1.0, 1.0)
    ]
    return join([surface, *pipes])


def bowl(inner: float, height: float, turn: Range) -> Solid:
    """A wall round the origin whose inside is a transition; inner radius in [m], turn in [rad]."""
    x, h = transition(height, 1.25, 20)
    outer = inner + x[-1] + 0.25
    profile = [(inner, 0.0), *zip(inner + x, h, strict=True), (outer, height), (outer, 0.0)]
    angles = np.linspace(*turn, 64)
    rings = [[(r * np.cos(a), r * np.sin(a), z) for r, z in profile] for a in angles]
    tips = [((outer - 0.02) * np.cos(a), (outer - 0.02) * np.sin(a), 0.02) for a in turn]
    edge = [((inner + x[-1]) * np.cos(a), (inner + x[-1]) * np.sin(a), height) for a in angles]
    return join([loft(rings, tips), tube(edge, 0.03)])


def bank(width: float) -> Solid:
    """A plane slope from the y axis up toward +x, with a deck; [m]."""
    return ramp([0.0, 0.7, 1.0], [LIP, 0.5, 0.5], (-width / 2, width / 2))


def rail(corners: Sequence[tuple[float, float]]) -> Solid:
    """A round bar on posts along a line on the floor; [m]."""
    line = np.array([(x, y, 0.42) for x, y in corners])
    bar = tube(bent(line, 0.8) if len(line) > 2 else line, 0.03)
    post, foot = cylinder(0.025, (0.0, 0.42), 12), cylinder(0.09, (0.0, 0.02), 16)
    places = [line[0] + (line[1] - line[0]) * 0.1, line[-1] + (line[-2] - line[-1]) * 0.1]
    return join([bar, *(part.moved(x, y) for x, y, _ in places for part in (post, foot))])


def planter() -> Solid:
    """A round concrete tub with a shrub, on the origin; [m]."""
    profile = [(0.0, 0.0), (0.42, 0.0), (0.5, 0.5), (0.54, 0.5), (0.54, 0.6), (0.46, 0.6)]
    tub = turned([*profile, (0.44, 0.45), (0.0, 0.45)], 32)
    return join([tub, _shrub()])


def _shrub() -> Solid:
    """A ball of leaves: its radius varies smoothly with direction."""
    tilt = np.linspace(0.0, np.pi, 15)[:, None]
    turn = 2.0 * np.pi * np.arange(24)[None] / 24
    bumps = 0.05 * np.sin(5 * turn + 2 * tilt) * np.sin(4 * tilt) + 0.03 * np.sin(3 * turn)
    r = 0.42 + np.sin(tilt) * bumps
    across = r * np.sin(tilt)
    rings = [across * np.cos(turn), across * np.sin(turn), 0.92 + r * np.cos(tilt) + 0 * turn]
    return loft(np.stack(rings, axis=2))


def _fence(y: Range, height: float) -> Solid:
    """Posts and two bars along y on a deck."""
    posts = [
        cylinder(0.025, (height - 0.1, height + 0.8), 12).moved(0, place)
        for place in np.linspace(*y, 5)
    ]
    bars = [tube([(0, y[0], height + z), (0, y[1], height + z)], 0.02, 12) for z in (0.4, 0.78)]
    return join([*posts, *bars])


MESHES = {"skate_park.ply": skate_park}
