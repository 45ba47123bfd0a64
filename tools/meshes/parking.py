"""A car park of 24 m by 16 m and the cars that stand in it.

parking_cars.obj, Y UP (up = "y"), [m]: one car. Once upright its nose points along +x, the middle
of its footprint is the origin, its wheels stand on z = 0; 4.3 m by 1.8 m by 1.45 m, and 1.98 m
wide at its mirrors.

parking_kerb.stl, z up, [m]: the car park itself.

| what             | x              | y                        | top  | remark                     |
|------------------|----------------|--------------------------|------|----------------------------|
| floor (free)     | 0 to 24        | 0 to 16                  |      |                            |
| outer walls      | -0.3 to 24.3   | -0.3 to 16.3             | 1.1  | 0.3 m thick, round it all  |
| entrance         | -0.3 to 0      | 5.2 to 10.8              |      | the only opening           |
| lane (free)      | 0 to 24        | 5 to 11                  |      | along x                    |
| lower bays       | 2 to 22        | 0 to 5                   |      | eight, 2.5 m wide          |
| upper bays       | 2 to 22        | 11 to 16                 |      | eight, 2.5 m wide          |
| wheel stops      | bay's middle   | 0.6 to 0.75, 15.25 to 15.4| 0.1 | 1.6 m wide, one per bay    |
| islands          | 0 to 2,22 to 24| 0 to 4.8, 11.2 to 16     | 0.15 | rounded; a tree on each    |
| pillars          | 2, 9.5, 17, 22 | 4.3, 11.7                | 2.6  | middles; 0.4 m square      |

Bay k = 0, 1, ..., 7 has its middle at x = 3.25 + 2.5 k: 3.25, 5.75, 8.25, 10.75, 13.25, 15.75,
18.25, 20.75; at y = 2.5 below and 13.5 above (``bay``). A car in bay 4 above, (13.25, 13.5), has
neighbours at (10.75, 13.5) and (15.75, 13.5) and no pillar beside it. Parked nose to the wall, a
car has yaw +pi/2 above and -pi/2 below.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from solids import Array, Range, Solid, block, box, cylinder, join, loft, tube, turned

WHEEL, AXLES, SIDE = 0.31, 1.3, 0.86  # [m] radius of a wheel, its place, half width of the body
CABIN_Z, CABIN_WIDTH = (0.86, 1.42), (0.80, 0.62)  # [m] at the cabin's lower and upper edge
CABIN_X = ((-1.85, 1.1), (-1.2, 0.3))  # [m] likewise

# Along the body: x, lower edge, upper edge, half width; [m].
BODY = np.array(
    [
        *((-2.15, 0.45, 0.74, 0.70), (-2.11, 0.34, 0.84, 0.79), (-1.95, 0.26, 0.91, 0.84)),
        *((-1.6, 0.2, 0.94, SIDE), (-0.6, 0.18, 0.93, SIDE), (0.6, 0.18, 0.92, SIDE)),
        *((1.1, 0.18, 0.88, SIDE), (1.6, 0.2, 0.80, 0.85), (1.9, 0.25, 0.73, 0.82)),
        *((2.09, 0.3, 0.65, 0.74), (2.15, 0.38, 0.58, 0.64)),
    ]
)


def bay(k: int, upper: bool) -> tuple[float, float]:
    """Return the middle (x, y) of bay ``k`` in [m]."""
    return 3.25 + 2.5 * k, 13.5 if upper else 2.5


def car() -> Solid:
    """Return a hatchback in a file whose y points up."""
    wheels = [
        part.moved(x, 0)
        for x in (-AXLES, AXLES)
        for side in (-1.0, 1.0)
        for part in (_wheel(side), _arch(side))
    ]
    trim = [part for side in (-1.0, 1.0) for part in (_side_windows(side), _fittings(side))]
    plates = [_screen(1, 0.06), _screen(0, 0.06)]
    bumpers = [
        block((-2.15, -2.0), (-0.7, 0.7), (0.36, 0.5), 0.03),
        block((2.0, 2.15), (-0.66, 0.66), (0.32, 0.46), 0.03),
    ]
    return join([_body(), _cabin(), *wheels, *trim, *plates, *bumpers]).with_y_up()


def kerb() -> Solid:
    """Return walls, wheel stops, islands and pillars of the car park."""
    bays = [bay(k, upper) for upper in (False, True) for k in range(8)]
    stops = [_stop().moved(x, 0.675 if y < 8 else 15.325) for x, y in bays]
    pillars = [_pillar().moved(x, y) for x in (2.0, 9.5, 17.0, 22.0) for y in (4.3, 11.7)]
    islands = [
        _island().moved(x, y, yaw=turn)
        for x in (1.0, 23.0)
        for y, turn in ((0.0, 0.0), (16.0, np.pi))
    ]
    return join([*_walls(), *stops, *pillars, *islands])


def _body() -> Solid:
    x = np.unique(np.concatenate([np.linspace(-2.15, 2.15, 25), BODY[:, 0]]))
    low, high, half = (np.interp(x, BODY[:, 0], BODY[:, k]) for k in (1, 2, 3))
    corner = 0.09
    rings = [
        [(a, y, z) for y, z in _rounded((-w, w), (b, t), corner)]
        for a, b, t, w in zip(x, low, high, half, strict=True)
    ]
    return loft(rings)


def _cabin() -> Solid:
    (low, high), (wide, narrow) = CABIN_Z, CABIN_WIDTH
    (x0, x1), (x2, x3) = CABIN_X
    outlines = [
        (low, _rounded((x0, x1), (-wide, wide), 0.12)),
        (high, _rounded((x2, x3), (-narrow, narrow), 0.12)),
        (high + 0.03, _rounded((x2 + 0.1, x3 - 0.1), (0.08 - narrow, narrow - 0.08), 0.1)),
    ]
    return loft([[(x, y, z) for x, y in outline] for z, outline in outlines])


def _rounded(x: Range, y: Range, radius: float, steps: int = 3) -> list[tuple[float, float]]:
    """Return a rectangle with round corners, counterclockwise from its right side."""
    corners = [
        (x[1] - radius, y[1] - radius),
        (x[0] + radius, y[1] - radius),
        (x[0] + radius, y[0] + radius),
        (x[1] - radius, y[0] + radius),
    ]
    turns = np.linspace(0.0, np.pi / 2, steps + 1)
    return [
        (a + radius * np.cos(turn + k * np.pi / 2), b + radius * np.sin(turn + k * np.pi / 2))
        for k, (a, b) in enumerate(corners)
        for turn in turns
    ]


def _side_windows(side: float) -> Solid:
    """Two panes that stand a little out of the cabin's side."""
    panes = []
    for front, back in ((0.96, 0.52), (0.46, 0.12)):  # shares of the cabin's length
        corners = [
            (share, z)
            for share, z in ((back, 0.98), (front - 0.04, 0.98), (front - 0.04, 1.36), (back, 1.36))
        ]
        panes.append(
            _pane([_on_cabin(share, z, side) for share, z in corners], np.array([0.0, side, 0.0]))
        )
    return join(panes)


def _screen(end: int, inset: float) -> Solid:
    """The windscreen (``end`` 1) or the rear window (0)."""
    corners = []
    for z, sides in ((0.97, (-1.0, 1.0)), (1.37, (1.0, -1.0))):
        share = (z - CABIN_Z[0]) / (CABIN_Z[1] - CABIN_Z[0])
        x = (1 - share) * CABIN_X[0][end] + share * CABIN_X[1][end]
        half = (1 - share) * CABIN_WIDTH[0] + share * CABIN_WIDTH[1] - 0.1 - inset
        corners += [np.array([x, side * half, z]) for side in sides]
    return _pane(corners, np.array([2.0 * end - 1.0, 0.0, 0.5]))


def _on_cabin(along: float, z: float, side: float) -> Array:
    """Return a point on the cabin's flank, at a share of the way from its back to its front."""
    share = (z - CABIN_Z[0]) / (CABIN_Z[1] - CABIN_Z[0])
    x0, x1 = ((1 - share) * np.array(CABIN_X[0]) + share * np.array(CABIN_X[1])).tolist()
    half = (1 - share) * CABIN_WIDTH[0] + share * CABIN_WIDTH[1]
    return np.array([x0 + along * (x1 - x0), side * half, z])


def _pane(corners: Sequence[Array], outward: Array) -> Solid:
    """A plate on four corners, 12 mm out of the surface and 30 mm into it."""
    outer, inner = 0.012 * outward, -0.03 * outward
    return loft([[c + outer for c in corners], [c + inner for c in corners]])


def _wheel(side: float) -> Solid:
    """A wheel whose axle lies along y: the tyre, the rim's recess and the hub."""
    r = WHEEL
    tyre = [(0.0, 0.0), (r - 0.03, 0.0), (r, 0.03), (r, 0.17), (r - 0.03, 0.2), (0.2, 0.2)]
    disc = turned([*tyre, (0.18, 0.17), (0.06, 0.18), (0.05, 0.2), (0.0, 0.2)], 28)
    flank = disc.along("y").vertices * (1.0, side, 1.0) + (0.0, 0.7 * side, r)
    return Solid(flank, disc.faces if side > 0 else disc.faces[:, ::-1])


def _arch(side: float) -> Solid:
    """The lip of a wheel arch."""
    turn = np.linspace(-0.15, np.pi + 0.15, 17)
    path = [(0.37 * np.cos(a), side * (SIDE - 0.01), WHEEL + 0.37 * np.sin(a)) for a in turn]
    return tube(path, 0.03, 8)


def _fittings(side: float) -> Solid:
    """Lamps, mirror and door handles of one side."""
    head, tail = box((0.1, 0.3, 0.1), (2.1, 0.5 * side, 0.52), 0.02), (-2.11, 0.62 * side, 0.62)
    mirror = box((0.1, 0.2, 0.13), (0.62, 0.89 * side, 0.93), 0.03)
    handles = [
        box((0.18, 0.03, 0.03), (x, (SIDE + 0.005) * side, 0.78), 0.008) for x in (-0.2, -1.05)
    ]
    return join([head, box((0.08, 0.26, 0.16), tail, 0.02), mirror, *handles])


def _walls() -> list[Solid]:
    """Parapets with a coping; the entrance is left open."""
    spans = [
        *(((-0.3, 24.3), (-0.3, 0.0)), ((-0.3, 24.3), (16.0, 16.3)), ((24.0, 24.29), (-0.1, 16.1))),
        *(((-0.29, 0.0), (-0.1, 5.2)), ((-0.29, 0.0), (10.8, 16.1))),
    ]
    low = [block(x, y, (0, 1.02)) for x, y in spans]
    caps = [block(x, y, (1.0, 1.1), 0.02) for x, y in spans]
    return [*low, *caps]


def _stop() -> Solid:
    """A wheel stop: a low beam with sloping ends."""
    return loft(
        [
            [(x, -0.075, 0), (x, 0.075, 0), (x, 0.05, h), (x, -0.05, h)]
            for x, h in ((-0.8, 0.03), (-0.7, 0.1), (0.7, 0.1), (0.8, 0.03))
        ]
    )


def _pillar() -> Solid:
    """A concrete pillar with a guard round its foot."""
    return join([box((0.34, 0.34, 2.6), (0, 0, 0), 0.03), box((0.4, 0.4, 0.7), (0, 0, 0), 0.04)])


def _island() -> Solid:
    """A kerbed island 1.9 m wide whose far end is round, with a tree; it grows toward +y."""
    turn = np.linspace(0.0, np.pi, 25)
    rim = [(0.95 * np.cos(a), 3.85 + 0.95 * np.sin(a)) for a in turn]
    outline = np.array([*rim, (-0.95, 0.02), (0.95, 0.02)])
    middle = outline.mean(axis=0)
    rings = [(1.0, 0.0), (1.0, 0.12), (0.97, 0.15)]
    kerbstone = loft(
        [
            np.column_stack([middle + f * (outline - middle), np.full(len(outline), z)])
            for f, z in rings
        ]
    )
    return join([kerbstone, cylinder(0.09, (0.1, 1.6), 12).moved(0, 2.4), _crown().moved(0, 2.4)])


def _crown() -> Solid:
    """The leaves of a tree: a ball whose radius varies smoothly."""
    tilt = np.linspace(0.0, np.pi, 13)[:, None]
    turn = 2.0 * np.pi * np.arange(20)[None] / 20
    r = 0.8 + np.sin(tilt) * 0.08 * np.sin(4 * turn + 3 * tilt)
    rings = [
        r * np.sin(tilt) * np.cos(turn),
        r * np.sin(tilt) * np.sin(turn),
        2.1 + r * np.cos(tilt) + 0 * turn,
    ]
    return loft(np.stack(rings, axis=2))


MESHES = {"parking_cars.obj": car, "parking_kerb.stl": kerb}
