"""A hall of 24 m by 14 m under a bridge crane whose rails lie at z = 9 m.

factory.glb, z up (glTF viewers expect y up), [m]. A row of machines across the hall parts the
loading bay from the shop; the straight way from (3, 3) to (21, 11) is blocked up to z = 7.2 m.

| what                      | x            | y            | top      | remark                |
|---------------------------|--------------|--------------|----------|-----------------------|
| loading bay (free)        | 1.0 to 5.0   | 1.0 to 5.0   |          | the start is (3, 3)   |
| row: machining centre     | 10.3 to 12.7 | 0.4 to 4.0   | 4.0      | may be flown over     |
| row: C-frame press        | 10.1 to 12.9 | 4.3 to 6.8   | 7.2      |                       |
| row: tank                 | 10.3 to 12.7 | 6.9 to 9.3   | 7.2      |                       |
| row: the gap              | 10 to 13     | 9.3 to 11.9  |          | 2.6 m wide            |
| row: silo                 | 10.6 to 12.4 | 11.9 to 13.7 | 7.2      |                       |
| slot: machine on its left | 18.0 to 19.8 | 9.6 to 12.4  | 3.0      |                       |
| slot (free)               | 19.8 to 22.2 | 9.6 to 14    |          | the goal is (21, 11)  |
| slot: machine on its right| 22.2 to 24.0 | 9.6 to 12.4  | 3.0      |                       |
| conveyor with boxes       | 0.8 to 8.4   | 7.8 to 8.8   | 1.6      |                       |
| C-frame presses           | 6.5, 18.0    | 12.2, 6.4    | 3.6, 4.2 | middles               |
| tanks, connected          | 16.8, 20.2   | 2.2          | 5.0      | middles, radius 1.1   |
| pallets of crates         | 0.8 to 23.4  |              | 2.2      | at ``PALLETS``        |

factory_pipes.ply, z up, [m]: pipes along y near x = 14 m.

| what             | x              | y             | z            | remark                       |
|------------------|----------------|---------------|--------------|------------------------------|
| run to the tank  | 13.85 to 14.15 | 0.2 to 8.3    | 5.55 to 5.85 | starts at the floor          |
| run beside it    | 14.37 to 14.63 | 0.6 to 8.9    | 5.57 to 5.83 | starts and ends at the floor |
| portals          | 13.3 to 15.2   | 2.5, 6.0      | 0 to 5.56    | two posts and a beam each    |
| the gap          |                | 8.9 to 12.6   |              | opposite the gap in the row  |
| run to the silo  | 13.85 to 14.15 | 12.6 to 13.8  | 5.55 to 5.85 | starts at the floor          |

A package that comes over the machining centre passes the pipes above them: its underside must be
higher than 5.9 m, where their flanges end.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from solids import Range, Solid, bent, block, box, cylinder, join, tube, turned, vessel

# Middle (x, y) in [m], yaw in [rad], and how many crates lie on top of each other.
PALLETS: Sequence[tuple[float, float, float, int]] = (
    *((1.4, 11.6, 0.05, 2), (2.9, 11.7, -0.04, 1), (1.5, 13.0, 0.0, 2), (3.1, 13.0, 0.1, 2)),
    *((7.6, 1.2, 0.0, 2), (7.7, 2.7, 0.06, 1), (8.0, 5.8, 1.5, 2), (15.8, 12.6, 0.0, 2)),
    *((22.6, 1.4, 0.0, 2), (22.7, 2.9, -0.05, 1), (22.5, 5.6, 0.08, 2), (15.9, 9.2, 0.3, 1)),
)


def factory() -> Solid:
    """Return all that stands on the floor but the overhead pipes."""
    quarter = np.pi / 2
    return join(
        [
            machining_centre(3.6, 2.4, 4.0).moved(11.5, 2.2, yaw=-quarter),
            press(2.4, 2.8, 7.2).moved(11.5, 5.6, yaw=-quarter),
            tank(1.2, 7.2).moved(11.5, 8.1),
            tank(0.9, 7.2).moved(11.5, 12.8),
            machining_centre(1.8, 2.8, 3.0).moved(18.9, 11.0),
            machining_centre(1.8, 2.8, 3.0).moved(23.1, 11.0),
            conveyor(7.6).moved(4.6, 8.3),
            press(1.8, 2.2, 3.6).moved(6.5, 12.2),
            press(2.0, 2.4, 4.2).moved(18.0, 6.4, yaw=quarter),
            tank(1.1, 5.0).moved(16.8, 2.2),
            tank(1.1, 5.0).moved(20.2, 2.2),
            _tank_pipes(),
            *(_pallet(crates).moved(x, y, yaw=yaw) for x, y, yaw, crates in PALLETS),
        ]
    )


def overhead_pipes() -> Solid:
    """Return pipe runs with elbows, on portals."""
    runs = [
        ([(14.0, 0.35, 0), (14.0, 0.35, 5.7), (14.0, 8.1, 5.7), (12.5, 8.1, 5.7)], 0.15),
        ([(14.5, 0.75, 0), (14.5, 0.75, 5.7), (14.5, 8.75, 5.7), (14.5, 8.75, 0)], 0.13),
        ([(14.0, 13.6, 0), (14.0, 13.6, 5.7), (14.0, 12.8, 5.7), (12.3, 12.8, 5.7)], 0.15),
    ]
    tubes = [tube(bent(corners, 0.38), radius, sections=24) for corners, radius in runs]
    flanges = [_flange(14.0, y, 0.15) for y in (1.6, 4.2, 7.0)]
    flanges += [_flange(14.5, y, 0.13) for y in (1.6, 4.2, 7.0)]
    return join([*tubes, *flanges, _portal(2.5), _portal(6.0)])


def machining_centre(width: float, depth: float, height: float) -> Solid:
    """A closed machine tool on the origin whose door looks toward -y; [m]."""
    front, side, base = -depth / 2, width / 2, 0.16 * height
    body = block((0.02 - side, side - 0.02), (front + 0.12, depth / 2), (0.06, 0.86 * height), 0.05)
    feet = [
        cylinder(0.08, (0.0, 0.1), 12).moved(x, y)
        for x in (0.2 - side, side - 0.2)
        for y in (front + 0.4, depth / 2 - 0.3)
    ]
    apron = block((-side + 0.05, side - 0.05), (front, front + 0.4), (0.1, base), 0.03)
    cab = block((-0.4 * side, 0.9 * side), (0, depth / 2 - 0.1), (0.8 * height, height), 0.06)
    lamp = cylinder(0.05, (0.8 * height, 0.94 * height), 16).moved(-0.8 * side, front + 0.4)
    details = [_door(-0.86 * side, 0.42 * side, front, (base + 0.05, 0.78 * height))]
    details += [_panel(0.68 * side, front, 0.45 * height), *_louvres(side, depth, height)]
    return join([body, *feet, apron, cab, lamp, *details])


def press(width: float, depth: float, height: float) -> Solid:
    """A C-frame press on the origin whose mouth opens toward -y; [m]."""
    side, front, back = width / 2, -depth / 2, depth / 2
    throat = back - 0.38 * depth
    cheeks = [
        block((x, x + 0.2 * width), (throat, back), (0.05, 0.97 * height), 0.04)
        for x in (-side, side - 0.2 * width)
    ]
    web = block((-side + 0.1, side - 0.1), (throat + 0.15, back - 0.1), (0.05, 0.95 * height))
    bed = block((-side, side), (front, back), (0, 0.28 * height), 0.05)
    head = block((-side, side), (front + 0.1, back), (0.66 * height, 0.94 * height), 0.06)
    table = block((-0.4 * width, 0.4 * width), (front + 0.05, throat), (0.2, 0.31 * height), 0.02)
    middle = (front + throat) / 2
    ram = block(
        (-0.3 * width, 0.3 * width),
        (middle - 0.4, middle + 0.4),
        (0.46 * height, 0.7 * height),
        0.03,
    )
    piston = cylinder(0.2 * width, (0.9 * height, height), 32, 0.03).moved(0, middle)
    return join([*cheeks, web, bed, head, table, ram, piston, *_drive(side, back, height)])


def tank(radius: float, height: float) -> Solid:
    """An upright tank with domed ends on four legs, on the origin; [m]."""
    shell = vessel(radius - 0.03, (0.35, height - 0.06), 0.45 * radius, 48)
    hoops = [_hoop(radius, z) for z in np.linspace(0.35 + radius, height - 0.6 * radius, 4)]
    leg = cylinder(0.09, (0.0, 0.4 + 0.8 * radius), 12)
    angle = np.pi / 4 + np.pi / 2 * np.arange(4)
    legs = [leg.moved(0.82 * radius * np.cos(a), 0.82 * radius * np.sin(a)) for a in angle]
    manhole = cylinder(0.28, (0, 0.2), 24, 0.02).along("y")
    nozzle = cylinder(0.12, (height - 0.15, height), 20)
    return join([shell, *hoops, *legs, manhole.moved(0, -radius, 1.2), nozzle])


def conveyor(length: float) -> Solid:
    """A roller conveyor along x, in the middle of the floor, with boxes on it; [m]."""
    half, top = length / 2, 0.8
    rails = [
        block((-half, half), (y - 0.04, y + 0.04), (top - 0.12, top + 0.06)) for y in (-0.46, 0.46)
    ]
    roller = cylinder(0.05, (-0.45, 0.45), 14).along("y")
    rollers = [roller.moved(x, 0, top) for x in np.arange(0.1 - half, half, 0.18)]
    legs = [
        block((x - 0.05, x + 0.05), (y - 0.05, y + 0.05), (0, top - 0.1))
        for x in np.linspace(0.2 - half, half - 0.2, 5)
        for y in (-0.44, 0.44)
    ]
    boxes = [
        box((0.6, 0.55, h), (x, 0, top + 0.04), 0.015)
        for x, h in ((-3.0, 0.5), (-1.7, 0.7), (-0.6, 0.4), (1.2, 0.75), (2.9, 0.5))
    ]
    return join([*rails, *rollers, *legs, *boxes])


def _door(left: float, right: float, front: float, z: Range) -> Solid:
    """A sliding door: a frame round a window, and a handle."""
    low, high = z
    bar = 0.12
    frame = [
        block((left, right), (front + 0.03, front + 0.14), (low, low + 2.5 * bar), 0.01),
        block((left, right), (front + 0.03, front + 0.14), (high - bar, high), 0.01),
        block((left, left + bar), (front + 0.03, front + 0.14), (low + bar, high - bar / 2), 0.01),
        block(
            (right - bar, right), (front + 0.03, front + 0.14), (low + bar, high - bar / 2), 0.01
        ),
    ]
    ends = ((0.1, 0.5), (-0.03, 0.5), (-0.03, 0.9), (0.1, 0.9))
    grip = [(right - 0.06, front + out, low + up) for out, up in ends]
    handle = tube(bent(grip, 0.04, 4), 0.018, 10)
    return join([*frame, handle])


def _panel(x: float, front: float, z: float) -> Solid:
    """A control panel with a screen and three buttons."""
    desk = block((x - 0.22, x + 0.22), (front + 0.02, front + 0.3), (z, z + 0.7), 0.02)
    screen = block((x - 0.16, x + 0.16), (front, front + 0.1), (z + 0.3, z + 0.6), 0.008)
    button = cylinder(0.035, (0.0, 0.08), 12, 0.008).along("y")
    return join(
        [desk, screen, *(button.moved(x + d, front - 0.01, z + 0.15) for d in (-0.11, 0.0, 0.11))]
    )


def _louvres(side: float, depth: float, height: float) -> list[Solid]:
    """Slats over the air inlets on both flanks."""
    y = (0.1 * depth, 0.38 * depth)
    return [
        block((x - 0.02, x + 0.02), y, (z, z + 0.05))
        for x in (0.02 - side, side - 0.02)
        for z in np.linspace(0.3, 0.6, 7) * height
    ]


def _drive(side: float, back: float, height: float) -> list[Solid]:
    """The flywheel in its guard and the motor of a press."""
    z, radius = 0.8 * height, 0.11 * height
    wheel = [(radius, 0.0), (radius, 0.1), (0.8 * radius, 0.1), (0.75 * radius, 0.05)]
    profile = [(0.0, 0.0), *wheel, (0.25 * radius, 0.05), (0.2 * radius, 0.12), (0.0, 0.12)]
    disc = turned(profile, 48).along("x").moved(side - 0.04, back - 1.2 * radius, z)
    motor = cylinder(0.2, (-0.3, 0.3), 24, 0.03).along("x").moved(0, back - 0.3, 0.955 * height)
    return [disc, motor]


def _hoop(radius: float, z: float) -> Solid:
    r = radius - 0.05
    return turned([(r, z - 0.04), (radius, z - 0.04), (radius, z + 0.04), (r, z + 0.04)], 48)


def _tank_pipes() -> Solid:
    """Pipes that lead from tank to tank and down to a pump."""
    upper = [(16.8, 2.2, 4.0), (16.8, 4.0, 4.0), (20.2, 4.0, 4.0), (20.2, 2.2, 4.0)]
    lower = [(16.8, 2.2, 1.3), (16.8, 3.8, 1.3), (16.8, 3.8, 0.35), (18.5, 3.8, 0.35)]
    pump = [
        box((1.2, 0.7, 0.12), (18.8, 3.8, 0.0), 0.02),
        cylinder(0.3, (-0.45, 0.45), 28, 0.05).along("x").moved(18.9, 3.8, 0.4),
    ]
    return join([tube(bent(upper, 0.3), 0.1, 20), tube(bent(lower, 0.25), 0.08, 20), *pump])


def _pallet(crates: int) -> Solid:
    """A pallet of 1.2 m by 1.0 m with crates on it, in the middle of the floor."""
    bearers = [box((1.2, 0.1, 0.1), (0, y, 0)) for y in (-0.45, 0.0, 0.45)]
    boards = [box((0.14, 1.0, 0.03), (x, 0, 0.1)) for x in np.linspace(-0.53, 0.53, 6)]
    stack = [_crate().moved(0, 0, 0.13 + 1.02 * k, yaw=0.05 * k) for k in range(crates)]
    return join([*bearers, *boards, *stack])


def _crate() -> Solid:
    """A box 1 m high whose edges are battens."""
    core = box((1.0, 0.8, 0.94), (0, 0, 0.03))
    posts = [box((0.1, 0.1, 1.0), (x, y, 0)) for x in (-0.48, 0.48) for y in (-0.38, 0.38)]
    rails = [box((1.04, 0.06, 0.09), (0, y, z)) for y in (-0.39, 0.39) for z in (0.01, 0.455, 0.9)]
    return join([core, *posts, *rails])


def _portal(y: float) -> Solid:
    posts = [box((0.18, 0.18, 5.4), (x, y, 0), 0.02) for x in (13.5, 15.0)]
    feet = [box((0.36, 0.36, 0.05), (x, y, 0)) for x in (13.5, 15.0)]
    return join([*posts, *feet, block((13.4, 15.1), (y - 0.09, y + 0.09), (5.37, 5.56), 0.02)])


def _flange(x: float, y: float, radius: float) -> Solid:
    return cylinder(radius + 0.05, (-0.04, 0.04), 24, 0.01).along("y").moved(x, y, 5.7)


MESHES = {"factory.glb": factory, "factory_pipes.ply": overhead_pipes}
