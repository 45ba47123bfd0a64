"""A gyroscope in two gimbals; a weight on its axle makes it precess."""

from kinolab.dynamics import (
    Body,
    Box,
    Disk,
    Sphere,
    System,
    Torque,
    Viscous,
    angle,
    move,
    parameter,
    rate,
    rot_x,
    rot_y,
    rot_z,
    toward,
)


def gyroscope() -> System:
    m, R = parameter("m", 1.8, "kg"), parameter("R", 0.06, "m")  # of the rotor
    w, d = parameter("w", 0.2, "kg"), parameter("d", 0.1, "m")  # the weight, and how far out it is
    g, c = parameter("g", 9.81, "m/s^2"), parameter("c", 0.001, "N m s/rad")
    psi = angle("psi", speed=10.0)  # outer gimbal, about the vertical
    theta = angle("theta", -1.3, 1.3, speed=10.0)  # inner gimbal, about the outer one's x
    phi = angle("phi", speed=400.0)  # rotor, about its axle, along y
    outer = move(0, 0, 0.4) @ rot_z(psi)
    inner = outer @ rot_x(theta)
    spinning = inner @ rot_y(phi)
    across = (Box(0.3, 0.02, 0.02, at=(0, 0, 0.15)), Box(0.3, 0.02, 0.02, at=(0, 0, -0.15)))
    sides = (Box(0.02, 0.02, 0.3, at=(0.15, 0, 0)), Box(0.02, 0.02, 0.3, at=(-0.15, 0, 0)))
    outer_ring = Body(
        "outer gimbal", outer, mass=0.6, inertia=(0.009, 0.018, 0.009), shape=(*across, *sides)
    )
    inner_ring = Body(
        "inner gimbal",
        inner,
        mass=0.4,
        inertia=(0.0028, 0.0028, 0.0056),
        shape=[
            *(Box(0.02, 0.22, 0.02, at=(side, 0, 0)) for side in (0.1, -0.1)),
            *(Box(0.22, 0.02, 0.02, at=(0, side, 0)) for side in (0.1, -0.1)),
        ],
    )
    rotor = Body(
        "rotor",
        spinning,
        mass=m,
        inertia=(m * R**2 / 4, m * R**2 / 2, m * R**2 / 4),
        shape=Disk(R, 0.02, axis="y"),
    )
    weight = Body("weight", inner @ move(0, d, 0), mass=w, shape=Sphere(0.02))
    return System(
        "gyroscope",
        bodies=[outer_ring, inner_ring, rotor, weight],
        gravity=toward("-z", g),
        inputs=[
            Torque("turn", on=outer_ring, about=outer.z, limit=0.5),
            Torque("tilt", on=inner_ring, about=outer.x, limit=0.5, reacts_on=outer_ring),
            Torque("spin", on=rotor, about=inner.y, limit=0.2, reacts_on=inner_ring),
        ],
        efforts=[Viscous(rate(psi), c), Viscous(rate(theta), c), Viscous(rate(phi), c)],
    )
