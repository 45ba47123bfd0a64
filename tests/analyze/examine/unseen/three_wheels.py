"""A satellite that three reaction wheels turn (a copy of kinolab.systems.satellite)."""

from kinolab.dynamics import (
    Body,
    Box,
    Disk,
    System,
    Torque,
    Viscous,
    angle,
    move,
    orient,
    parameter,
    rate,
    rot_x,
    rot_y,
    rot_z,
    rotation,
)

FASTEST = 418.9  # [rad/s], 4000 turns a minute
TURNS = {"x": rot_x, "y": rot_y, "z": rot_z}
SEATS = {"x": (-0.3, -0.2, 0.5), "y": (-0.1, 0.22, 0.5), "z": (0.25, -0.2, 0.45)}  # [m]


def three_wheels() -> System:
    I_w, c = parameter("I_w", 0.01, "kg m^2"), parameter("c", 1e-4, "N m s/rad")
    bus = orient(rotation("R", speed=0.1))
    hull = Body("bus", bus, inertia=(10.0, 12.0, 8.0), shape=Box(1.0, 1.0, 1.2))
    wheels, motors, bearings = [], [], []
    for axis, turn in TURNS.items():
        q = angle(f"wheel_{axis}", speed=FASTEST, scale=1000.0)
        moments = tuple(I_w if other == axis else I_w / 2 for other in "xyz")
        seat = bus @ move(*SEATS[axis]) @ turn(q)
        wheel = Body(f"{axis} wheel", seat, inertia=moments, shape=Disk(0.17, 0.07, axis=axis))
        wheels.append(wheel)
        about = getattr(bus, axis)
        motors.append(Torque(f"tau_{axis}", on=wheel, about=about, limit=0.1, reacts_on=hull))
        bearings.append(Viscous(rate(q), c))
    return System("three_wheels", bodies=[hull, *wheels], inputs=motors, efforts=bearings)
