"""A yard of 6 m by 4.2 m and the loading bays on its far side, for a robot of 0.7 m.

loading_bay.stl, z up, [m]: the yard itself.

| what               | x                          | y           | top  | remark                  |
|--------------------|----------------------------|-------------|------|-------------------------|
| yard (free)        | 0 to 6                     | 0 to 3      |      |                         |
| bays (free)        | 1.455 to 2.445, …          | 3 to 4.1    |      | three, 1.05 m apart     |
| kerbs              | 1.425, 2.475, 3.525, 4.575 | 3 to 4.1    | 0.1  | middles; 0.06 m wide    |
| wall of the dock   | 1 to 5                     | 4.1 to 4.35 | 0.55 | behind the bays         |
| buffers            | bay's middle ± 0.25        | 4.04 to 4.1 | 0.3  | rubber, two on the wall |
| bollards           | 1.425, 4.575               | 2.85        | 0.6  | middles; 0.07 m radius  |
| fence              | 0 to 6                     | 0 to 4.2    | 0.4  | round the yard          |

Bay k = 0, 1, 2 has its middle at x = 1.95, 3, 4.05; a robot that stands in it heads along +y, with
the middle of its wheels at y = 3.58.

pallet_load.obj, z up, [m]: half a pallet (0.8 m by 0.6 m) with cartons, 0.66 m high; its middle is
the origin.
"""

from __future__ import annotations

from collections.abc import Iterator

from solids import Solid, block, box, cylinder, join

BAYS = (1.95, 3.0, 4.05)  # [m] middles along x
KERBS = (1.425, 2.475, 3.525, 4.575)  # [m] likewise


def loading_bay() -> Solid:
    """Return kerbs, wall, buffers, bollards and fence."""
    kerbs = [block((x - 0.03, x + 0.03), (3.0, 4.12), (0, 0.1), 0.012) for x in KERBS]
    buffers = [
        block((x + side - 0.05, x + side + 0.05), (4.04, 4.12), (0.06, 0.3), 0.015)
        for x in BAYS
        for side in (-0.25, 0.25)
    ]
    wall = [block((1, 5), (4.1, 4.35), (0, 0.5)), block((0.98, 5.02), (4.08, 4.37), (0.49, 0.55))]
    bollards = [cylinder(0.07, (0, 0.6), 24, 0.02).moved(x, 2.85) for x in (KERBS[0], KERBS[-1])]
    return join([*kerbs, *buffers, *wall, *bollards, *_fence()])


def _fence() -> Iterator[Solid]:
    """Posts with two rails, along three sides of the yard and beside the dock."""
    runs = [(-0.1, -0.1, 0.0, 6.2), (-0.1, -0.1, 1.0, 4.3), (6.1, -0.1, 1.0, 4.3)]
    runs += [(-0.1, 4.2, 0.0, 1.05), (5.05, 4.2, 0.0, 1.05)]
    posts = set[tuple[float, float]]()
    for x, y, along, far in runs:
        across = 1.0 - along
        count = max(2, round(far / 1.5) + 1)
        for k in range(count):
            s = far * k / (count - 1)
            posts.add((round(x + across * s, 6), round(y + along * s, 6)))  # one at a corner
        for height in (0.14, 0.3):
            size = (far if across else 0.03, far if along else 0.03, 0.06)
            yield box(size, (x + across * far / 2, y + along * far / 2, height))
    for x, y in sorted(posts):
        yield box((0.06, 0.06, 0.4), (x, y, 0))


def pallet_load() -> Solid:
    """Return half a pallet with two layers of cartons; of the upper one a carton is missing."""
    bearers = [box((0.8, 0.09, 0.1), (0, y, 0)) for y in (-0.25, 0.0, 0.25)]
    boards = [box((0.12, 0.6, 0.03), (x, 0, 0.1)) for x in (-0.34, -0.17, 0.0, 0.17, 0.34)]
    spots = [(x, y, z) for z in (0, 1) for x in (-1, 0, 1) for y in (-1, 1)]
    cartons = [
        box((0.25, 0.28, 0.26), (0.26 * x, 0.145 * y, 0.13 + 0.265 * z)) for x, y, z in spots[:-1]
    ]
    return join([*bearers, *boards, *cartons])


MESHES = {"loading_bay.stl": loading_bay, "pallet_load.obj": pallet_load}
