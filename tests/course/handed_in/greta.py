"""A lift and its counterweight on a drum."""

from kinolab.dynamics import *


def lift() -> System:
    m, M, R = parameter("m", 600.0, "kg"), parameter("M", 500.0, "kg"), parameter("R", 0.3, "m")
    z, w = length("z", 1.0, 20.0, speed=2.0), length("w", 1.0, 20.0, speed=2.0)
    phi = angle("phi", speed=7.0)
    shaft = move(0, 0, 24.0)
    cabin = Body("cabin", move(R, 0, z), mass=m, shape=Box(0.5, 1.2, 2.0, at=(0.25, 0, 0)))
    weight = Body("counterweight", move(-R, 0, w), mass=M, shape=Box(0.25, 0.8, 1.0, at=(-0.1, 0, 0)))
    drum = Body(
        "drum", shaft @ rot_y(phi), mass=80.0, inertia=(2.0, 3.6, 2.0), shape=Disk(R, 0.3, axis="y")
    )
    return System(
        "lift",
        bodies=[cabin, weight, drum],
        gravity=toward("-z"),
        constraints=[
            zero(rate(z) + R * rate(phi), "the rope of the cabin"),
            zero(rate(w) - R * rate(phi), "the rope of the counterweight"),
        ],
        inputs=[Torque("motor", on=drum, about=WORLD.y, limit=900.0)],
        efforts=[Viscous(rate(phi), 20.0)],
        velocities=[phi],
    )
