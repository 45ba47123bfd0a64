"""A warehouse of 14 m by 10 m: four rows of pallet racks and a bay where a robot charges.

warehouse_racks.stl, z up, in MILLIMETRES (scale = 0.001). Here all is in [m]. The straight way
from (1, 1) to the bay is blocked by the first row. Aisles and gaps are 1.2 m wide.

| what                 | x            | y                      | top  | remark                   |
|----------------------|--------------|------------------------|------|--------------------------|
| row 1                | 2.2 to 3.2   | 0.2 to 3.8, 5.0 to 8.6 | 2.4  |                          |
| row 2                | 4.4 to 5.4   | 2.6 to 9.8             | 2.4  | no gap: pass at y < 2.6  |
| row 3                | 6.6 to 7.6   | 0.2 to 3.8, 5.0 to 8.6 | 2.4  |                          |
| row 4                | 8.8 to 9.8   | 1.4 to 5.0, 6.2 to 9.8 | 2.4  |                          |
| far wall             | 13.0 to 13.2 | 7.0 to 10.0            | 1.8  |                          |
| bay, free inside     | 12.3 to 12.9 | 8.25 to 8.95           |      | opens toward -x          |
| bay, its three walls | 12.25 to 13  | 8.15 to 9.05           | 0.35 | 0.1 m thick              |
| loose pallets        |              |                        | 1.2  | see ``LOOSE``            |
| cones                |              |                        | 0.45 | see ``CONES``            |

A robot whose axle stands at (12.6, 8.6), heading along +x, is in the bay.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from solids import Solid, block, box, cylinder, join, loft, tube, turned

BAY, DEPTH, HEIGHT = 1.75, 1.0, 2.4  # [m] of a rack: from upright to upright, and its other edges
POST = 0.08  # [m] edge of an upright
SHELF = 1.15  # [m] height of the beams' upper edge
Row = tuple[float, float, int]  # lowest x and y in [m], number of bays along y
ROWS: Sequence[Row] = (
    *((2.2, 0.2, 2), (2.2, 5.0, 2), (4.4, 2.6, 4)),
    *((6.6, 0.2, 2), (6.6, 5.0, 2), (8.8, 1.4, 2), (8.8, 6.2, 2)),
)
LOOSE = ((11.6, 1.6), (12.9, 1.8), (12.9, 4.2))  # middles (x, y) in [m]
CONES = ((11.2, 7.4), (11.2, 9.6))  # middles (x, y) in [m]


def warehouse() -> Solid:
    """Return racks, bay and wall in millimetres."""
    parts = [_row(row, start=2 * i) for i, row in enumerate(ROWS)]
    parts += [_pallet(2 * i + 1).moved(x, y) for i, (x, y) in enumerate(LOOSE)]
    parts += [_cone().moved(x, y) for x, y in CONES]
    return join([*parts, _dock()]).scaled(1000.0)


def _row(row: Row, start: int) -> Solid:
    """A rack along y with two pallets on the floor and two on the beams of each bay."""
    x, y, bays = row
    frames = [_frame().moved(0, BAY * i) for i in range(bays + 1)]
    shelves = [_beams().moved(0, BAY * i) for i in range(bays)]
    pallets = [
        _pallet(start + 3 * i + 2 * level + k).moved(DEPTH / 2, BAY * i + 0.46 + 0.83 * k, z)
        for i in range(bays)
        for level, z in enumerate((0.0, SHELF))
        for k in range(2)
    ]
    return join([*frames, *shelves, *pallets]).moved(x, y + POST / 2)


def _frame() -> Solid:
    """Two uprights on feet and the bracing between them, in the plane y = 0."""
    y = (-POST / 2, POST / 2)
    posts = [block((x, x + POST), y, (0, HEIGHT)) for x in (0.01, DEPTH - POST - 0.01)]
    feet = [block((x, x + 0.1), y, (0, 0.02)) for x in (0.0, DEPTH - 0.1)]
    steps = pairwise(np.linspace(0.25, HEIGHT - 0.2, 5))
    braces = [_brace(low, high, (-1.0) ** k) for k, (low, high) in enumerate(steps)]
    return join([*posts, *feet, *braces])


def _brace(low: float, high: float, side: float) -> Solid:
    """A bar that crosses a frame on its way up, in front of or behind its neighbours."""
    x, y = (DEPTH - 0.1) / 2 * side, 0.012 * side
    return tube([(DEPTH / 2 - x, y, low), (DEPTH / 2 + x, y, high)], 0.02, 4)


def _beams() -> Solid:
    """The two beams of a bay and the bars between them."""
    y = (0.03, BAY - 0.03)
    beams = [block((x, x + 0.05), y, (SHELF - 0.12, SHELF)) for x in (0.02, DEPTH - 0.07)]
    bars = [
        block((0.05, DEPTH - 0.05), (b - 0.03, b + 0.03), (SHELF - 0.05, SHELF - 0.01))
        for b in np.linspace(0.3, BAY - 0.3, 4)
    ]
    return join([*beams, *bars])


def _pallet(kind: int) -> Solid:
    """A pallet of 1.0 m by 0.8 m with one of several loads, in the middle of the floor."""
    bearers = [block((-0.48, 0.48), (y - 0.05, y + 0.05), (0, 0.1)) for y in (-0.34, 0.0, 0.34)]
    boards = [block((x - 0.07, x + 0.07), (-0.4, 0.4), (0.1, 0.13)) for x in (-0.42, 0.0, 0.42)]
    load = (_cartons, _sacks, _crate, _cartons, _drums)[kind % 5]
    return join([*bearers, *boards, load(kind).moved(0, 0, 0.13)])


def _cartons(kind: int) -> Solid:
    """Cartons in layers; the last layer is not always full."""
    spots = [(x, y, layer) for layer in range(2) for x in (-1, 0, 1) for y in (-1, 1)]
    edges, full = (0.31, 0.375, 0.4), 9 + kind % 4
    return join(box(edges, (0.32 * x, 0.19 * y, 0.405 * z)) for x, y, z in spots[:full])


def _crate(kind: int) -> Solid:
    """A wooden box with battens; its height varies."""
    height = 0.6 + 0.06 * (kind % 4)
    battens = [box((0.08, 0.78, 0.03), (x, 0, height)) for x in (-0.4, 0.0, 0.4)]
    rims = [block((-0.47, 0.47), (-0.39, 0.39), (z, z + 0.06)) for z in (0.02, height - 0.08)]
    return join([block((-0.45, 0.45), (-0.37, 0.37), (0, height)), *battens, *rims])


def _drums(kind: int) -> Solid:
    """Four drums; their height varies."""
    height = 0.66 + 0.04 * (kind % 3)
    drum = turned([(0.0, 0.0), (0.19, 0.0), (0.19, height), (0.0, height)], 12)
    return join(drum.moved(x, y) for x in (-0.25, 0.25) for y in (-0.2, 0.2))


def _sacks(kind: int) -> Solid:
    """Layers of sacks; their number varies."""
    spots = [(x, y, z) for z in range(3 + kind % 2) for x in (-1, 1) for y in (-1, 1)]
    return join(_sack().moved(0.245 * x, 0.195 * y, 0.17 * z) for x, y, z in spots)


def _sack() -> Solid:
    """A pillow: wide in the middle of its height."""
    edges = [(0.2, 0.15, 0.0), (0.24, 0.19, 0.09), (0.2, 0.15, 0.18)]
    return loft([[(-a, -b, z), (a, -b, z), (a, b, z), (-a, b, z)] for a, b, z in edges])


def _dock() -> Solid:
    """The bay, the wall behind it, and a charger on the wall."""
    walls = [block((12.3, 12.98), y, (0, 0.35), 0.01) for y in ((8.15, 8.25), (8.95, 9.05))]
    noses = [cylinder(0.05, (0, 0.34), 20, 0.01).moved(12.3, y) for y in (8.2, 9.0)]
    back = block((12.9, 13.0), (8.15, 9.05), (0, 0.36), 0.01)
    wall = block((13.0, 13.2), (7.0, 10.0), (0, 1.8))
    charger = block((12.86, 13.02), (8.35, 8.85), (0.75, 1.25), 0.03)
    screen = block((12.85, 12.9), (8.45, 8.75), (1.0, 1.18), 0.01)
    cable = tube([(12.94, 8.6, 0.8), (12.95, 8.6, 0.3)], 0.025, 12)
    return join([*walls, *noses, back, wall, charger, screen, cable])


def _cone() -> Solid:
    foot = box((0.3, 0.3, 0.04), (0, 0, 0), 0.01)
    return join([foot, turned([(0.0, 0.03), (0.12, 0.03), (0.03, 0.45), (0.0, 0.45)], 24)])


MESHES = {"warehouse_racks.stl": warehouse}
