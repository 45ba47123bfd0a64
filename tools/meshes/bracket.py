"""A gallows of steel girders that reaches into the circle of a pendulum.

pendulum_bracket.stl, x DOWN, y to the side, z along the pivot's axis, [m]. The pivot is the origin;
the bob, of radius 0.1 m, circles at 1 m in the plane z = 0; theta = 0 is at +x, pi/2 at +y.

| what                | x              | y              | z              | remark                |
|---------------------|----------------|----------------|----------------|-----------------------|
| beam                | -0.55 to -0.27 | 0.68 to 1.75   | -0.15 to 0.15  | its end: 0.75 m off   |
| column of the beam  | -0.92 to 1.54  | 1.6 to 2.2     | -0.3 to 0.3    | wide at its foot only |
| brace               | -0.32 to 0.34  | 1.29 to 1.81   | -0.04 to 0.04  | 1.3 m off             |
| post of the pivot   | -0.45 to 1.54  | -0.3 to 0.3    | -0.8 to -0.2   | wide at its foot only |
| bearing and motor   | -0.16 to 0.16  | -0.16 to 0.16  | -1.0 to -0.12  | behind the pendulum   |
| plinth              | 1.53 to 1.62   | -0.5 to 2.4    | -0.9 to 0.4    |                       |

The bob touches the beam from theta = 1.74 rad (100 degrees) to 2.28 rad (131 degrees) and is more
than 0.1 m away from everything below 1.64 rad (94 degrees) and above 2.42 rad (139 degrees).
"""

from __future__ import annotations

import numpy as np
from solids import Range, Solid, block, cylinder, join, loft, tube

PLATE = 0.03  # [m] thickness of flanges and webs


def bracket() -> Solid:
    """Return beam, column, post and plinth."""
    plinth = [block((1.53, 1.62), (-0.5, 2.4), (-0.9, 0.4), 0.02)]
    return join([*_beam(), *_column(), *_pivot_post(), *plinth])


def _beam() -> list[Solid]:
    """The cantilever along y with an end plate, stiffeners, a brace and bolts."""
    x, z, y = (-0.55, -0.27), (-0.15, 0.15), (0.71, 1.76)
    flanges = [block(edge, y, z) for edge in _edges(x)]
    web = block((-0.54, -0.28), y, (-PLATE / 2, PLATE / 2))
    end = block(x, (0.7, 0.7 + PLATE), z, 0.004)
    ribs = [block((-0.54, -0.28), (a, a + 0.015), (-0.135, 0.135)) for a in (1.0, 1.3, 1.6)]
    brace = tube([(-0.28, 1.32, 0.0), (0.3, 1.78, 0.0)], 0.04, 12)
    bolts = [_bolt("y").moved(a, 0.7, b) for a in (-0.48, -0.34) for b in (-0.09, 0.09)]
    return [*flanges, web, end, *ribs, brace, *bolts]


def _column() -> list[Solid]:
    """The column that carries the beam, on a foot, with gussets."""
    x, y, z = (-0.9, 1.54), (1.75, 2.05), (-0.15, 0.15)
    flanges = [block(x, edge, z) for edge in _edges(y)]
    web = block(x, (1.76, 2.04), (-PLATE / 2, PLATE / 2))
    top = block((-0.92, -0.89), (1.72, 2.08), (-0.18, 0.18), 0.004)
    gusset = _gusset([(-0.5, 1.5), (-0.5, 1.77), (-0.85, 1.77)])
    foot = block((1.5, 1.54), (1.6, 2.2), (-0.3, 0.3), 0.006)
    ribs = [_gusset([(1.51, a), (1.51, b), (1.3, b)]) for a, b in ((1.62, 1.76), (2.18, 2.04))]
    bolts = [_bolt("x").moved(1.5, a, b) for a in (1.66, 2.14) for b in (-0.24, 0.24)]
    return [*flanges, web, top, gusset, foot, *ribs, *bolts]


def _pivot_post() -> list[Solid]:
    """The post behind the pendulum with bearing, shaft and motor."""
    x, z = (-0.45, 1.54), (-0.65, -0.35)
    flanges = [block(x, (-0.15, 0.15), edge) for edge in _edges(z)]
    web = block(x, (-PLATE / 2, PLATE / 2), (-0.64, -0.36))
    foot = block((1.5, 1.54), (-0.3, 0.3), (-0.8, -0.2), 0.006)
    turn = np.pi / 3 * np.arange(6)
    bolts = [_bolt("z").moved(0.13 * np.cos(a), 0.13 * np.sin(a), -0.33) for a in turn]
    bolts += [_bolt("x").moved(1.5, a, b) for a in (-0.24, 0.24) for b in (-0.74, -0.26)]
    bearing = [
        cylinder(0.16, (-0.36, -0.33), 36, 0.006),
        cylinder(0.1, (-0.34, -0.18), 36, 0.015),
        cylinder(0.035, (-0.2, -0.12), 24, 0.006),
    ]
    motor = [cylinder(0.13, (-1.0, -0.64), 36, 0.02)]
    motor += [cylinder(0.138, (a, a + 0.015), 36) for a in np.linspace(-0.92, -0.72, 6)]
    return [*flanges, web, foot, *bolts, *bearing, *motor]


def _edges(span: Range) -> tuple[Range, Range]:
    """Return where the two flanges of a girder lie."""
    return (span[0], span[0] + PLATE), (span[1] - PLATE, span[1])


def _gusset(corners: list[tuple[float, float]]) -> Solid:
    """A triangular plate in the plane z = 0 with corners (x, y)."""
    return loft([[(x, y, z) for x, y in corners] for z in (-0.012, 0.012)])


def _bolt(axis: str) -> Solid:
    """A hexagon head that stands 2 cm out of a face: toward -x, -y or +z."""
    head = cylinder(0.025, (-0.02, 0.01), 6) if axis != "z" else cylinder(0.02, (-0.01, 0.02), 6)
    return head.along(axis)


MESHES = {"pendulum_bracket.stl": bracket}
