"""The truss of a space station with a tank and radiators, beside which a satellite floats.

truss.stl, z up, [m]. The satellite is at the origin. It may turn about z as it likes, but its wings
reach 2.9 m from there: turned about x they would strike.

| what                | x             | y            | z             |
|---------------------|---------------|--------------|---------------|
| truss               | -1.0 to 0.0   | -4.0 to 4.0  | -3.0 to -2.0  |
| tank                | -0.5          | -3.3         | -4.7 to -3.0  |
| radiators           | -3.4 to -1.0  | 0.2 to 3.8   | -2.5          |
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from solids import Array, Solid, block, join, tube, vessel

BAYS, BAY, SIDE = 8, 1.0, 1.0  # number and length in [m] of bays; edge of the square between beams
BEAM, BRACE = 0.05, 0.028  # [m] radii
MIDDLE = np.array([-0.5, 0.0, -2.5])  # of the truss


def truss() -> Solid:
    """Return all of it."""
    bars = [tube(np.array(ends) + MIDDLE, radius, 10) for ends, radius in _bars()]
    return join([*bars, *_tank(), *_radiators()])


def _bars() -> Iterator[tuple[list[Array], float]]:
    """Yield the ends and the radius of every bar, about the middle of the truss."""
    half = BAYS * BAY / 2
    for x, z in _corners():
        yield [np.array([x, -half, z]), np.array([x, half, z])], BEAM
    for k in range(BAYS + 1):
        y = k * BAY - half
        for a, b in zip(_corners(), [*_corners()[1:], _corners()[0]], strict=True):
            yield [np.array([a[0], y, a[1]]), np.array([b[0], y, b[1]])], BRACE
            if k < BAYS:
                there = y + BAY
                first, last = (a, b) if k % 2 else (b, a)
                yield (
                    [np.array([first[0], y, first[1]]), np.array([last[0], there, last[1]])],
                    BRACE,
                )


def _corners() -> list[tuple[float, float]]:
    s = SIDE / 2
    return [(-s, -s), (s, -s), (s, s), (-s, s)]


def _tank() -> list[Solid]:
    x, y = float(MIDDLE[0]), -3.3
    collar = block((x - 0.2, x + 0.2), (y - 0.2, y + 0.2), (-3.1, -2.95))
    return [vessel(0.7, (-4.7, -3.05), 0.35).moved(x, y), collar]


def _radiators() -> list[Solid]:
    arm = tube([(-1.0, 2.0, -2.5), (-3.3, 2.0, -2.5)], 0.04, 10)
    panels = [block((-3.4, -1.2), (y, y + 1.75), (-2.53, -2.47), bevel=0.01) for y in (0.2, 2.05)]
    return [arm, *panels]


MESHES = {"truss.stl": truss}
