"""A robot on four wheels that cannot be steered: to turn, it skids."""

from __future__ import annotations

from sympy import Expr

from kinolab.dynamics import (
    Body,
    Box,
    Cylinder,
    Disk,
    Frame,
    SlidingFriction,
    System,
    Torque,
    Viscous,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    rot_z,
    velocity,
)

RUBBER, STEEL = (0.13, 0.13, 0.15), (0.35, 0.37, 0.4)


def slip_steered() -> System:
    """A robot on four driven wheels; those of a side turn together, and it steers by skidding.

    In a turn the contacts cannot all roll: each slides against Coulomb friction along its own slip.
    The loads are those of equal suspension springs on level ground, and constant. The motors lose
    torque with speed, so that every torque has a steady speed.

    Source: Kozlowski, Pazderski, Modeling and control of a 4-wheel skid-steering mobile robot, Int.
    J. Applied Mathematics and Computer Science 14(4), 2004; Alexander, Maddocks, On the kinematics
    of wheeled mobile robots, IJRR 8(5), 1989 (the friction).
    """
    # m and I_z are those of the whole robot, I_z about its centre of mass; I_w is that of a wheel
    # with its share of motor and gears.
    m, I_z = parameter("m", 50.0, "kg"), parameter("I_z", 3.0, "kg m^2")
    I_w, c_w = parameter("I_w", 0.1, "kg m^2"), parameter("c_w", 4.0, "N m s/rad")
    a, c = parameter("a", 0.25, "m"), parameter("c", 0.3, "m")  # half of wheelbase and track
    r, g = parameter("r", 0.12, "m"), parameter("g", 9.81, "m/s^2")
    mu, eps = parameter("mu", 0.7), parameter("eps", 0.05, "m/s")  # tyres creep before they slide
    ahead, left = parameter("ahead", 0.0, "m"), parameter("left", 0.0, "m")  # centre of mass
    x, y = length("x", speed=1.0), length("y", speed=1.0)  # middle of the wheels
    psi = angle("psi", speed=2.0)  # heading
    phi_l, phi_r = angle("phi_l", speed=8.0), angle("phi_r", speed=8.0)
    middle = move(x, y, r) @ rot_z(psi)
    V = velocity(middle)
    chassis, mast = _chassis(middle, ahead, left, m, I_z - 2 * I_w)
    wheels, friction = [], []
    for side, phi, across in (("left", phi_l, c), ("right", phi_r, -c)):
        for end, along in (("front", a), ("rear", -a)):
            hub = middle @ move(along, across) @ rot_y(phi)
            wheels.append(_wheel(f"{end} {side} wheel", hub, r, I_w))
            slip = (V.x - across * V.wz - r * rate(phi), V.y + along * V.wz)
            load = m * g / 4 * (1 + along * ahead / a**2 + across * left / c**2)
            friction.append(SlidingFriction(slip, mu * load, eps))
    return System(
        "slip_steered",
        bodies=[chassis, mast, *wheels],
        inputs=[
            Torque("tau_l", on=wheels[0], about=middle.y, limit=30.0, reacts_on=chassis),
            Torque("tau_r", on=wheels[2], about=middle.y, limit=30.0, reacts_on=chassis),
        ],
        efforts=[*friction, Viscous(rate(phi_l), c_w), Viscous(rate(phi_r), c_w)],
    )


def _chassis(
    middle: Frame, ahead: Expr, left: Expr, mass: Expr, inertia: Expr
) -> tuple[Body, Body]:
    """Return the chassis, with its frame at the centre of mass, and what stands on it."""

    def place(x: float, z: float) -> tuple[Expr, Expr, float]:
        return x - ahead, -left, z

    hull = (Box(0.66, 0.44, 0.14, at=place(0, 0.03)), Box(0.46, 0.36, 0.06, at=place(-0.03, 0.13)))
    bumpers = tuple(Box(0.04, 0.5, 0.07, at=place(x, 0.02)) for x in (0.35, -0.35))
    head = (
        Cylinder(0.02, 0.2, at=place(0.15, 0.26)),
        Cylinder(0.05, 0.08, at=place(0.15, 0.4)),
    )
    frame = middle @ move(ahead, left)
    chassis = Body(
        "chassis", frame, mass=mass, inertia=inertia, shape=hull, color=(0.95, 0.72, 0.1)
    )
    return chassis, Body("bumpers and mast", frame, shape=(*bumpers, *head), color=STEEL)


def _wheel(name: str, hub: Frame, r: Expr, I_w: Expr) -> Body:
    return Body(
        name,
        hub,
        inertia=(I_w / 2, I_w, I_w / 2),
        shape=Disk(r, thickness=0.11, axis="y"),  # [m] of the wheels
        touches_ground=True,
        color=RUBBER,
    )
