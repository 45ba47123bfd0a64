"""A car with a driven rear axle and a steering actuator."""

import sympy

from kinolab.dynamics import (
    CURVATURE,
    Body,
    Box,
    Disk,
    PlaneCurves,
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
    zero,
)


def car() -> System:
    """A car: one torque drives the rear axle, another one turns the steered wheels.

    The two wheels of an axle are one, in the middle (the single-track model), and neither axle
    slips sideways.

    Source: Laumond (ed.), Robot Motion Planning and Control, 1998, chapter 1.
    """
    # I_z excludes the front wheels and is about the vertical through the centre of mass.
    m, I_z = parameter("m", 1200.0, "kg"), parameter("I_z", 2000.0, "kg m^2")
    L, a, R = parameter("L", 2.7, "m"), parameter("a", 1.3, "m"), parameter("R", 0.3, "m")
    I_w, J_s = parameter("I_w", 2.0, "kg m^2"), parameter("J_s", 5.0, "kg m^2")
    c_d, c_s = parameter("c_d", 72.0, "N m s/rad"), parameter("c_s", 50.0, "N m s/rad")
    x, y, psi = length("x"), length("y"), angle("psi")  # middle of the rear axle, heading
    delta = angle("delta", -0.6, 0.6, speed=0.8)  # steering angle
    phi = angle("phi", speed=10.0)  # rotation of the rear wheels
    sides = (1.5 / 2, -1.5 / 2)  # [m] between left and right wheels
    wheels = [Disk(R, thickness=0.2, axis="y", at=(0, side, 0)) for side in sides]
    rear = move(x, y, R) @ rot_z(psi)
    front = rear @ move(L) @ rot_z(delta)
    shell = (
        Box(4.2, 1.8, 0.6, at=(1.35 - a, 0, 0.25)),
        Box(2.2, 1.6, 0.5, at=(1.0 - a, 0, 0.75)),
    )
    chassis = Body("chassis", rear @ move(a), mass=m, inertia=I_z - I_w / 2, shape=shell)
    axle = Body(
        "rear axle",
        rear @ rot_y(phi),
        inertia=(I_w / 2, I_w, I_w / 2),
        shape=wheels,
        touches_ground=True,
    )
    steering = Body("front wheels", front, inertia=J_s, shape=wheels, touches_ground=True)
    V = velocity(rear)
    return System(
        "car",
        bodies=[chassis, axle, steering],
        constraints=[
            zero(V.y, "no sideslip behind"),
            zero(velocity(front).y, "no sideslip in front"),
            zero(V.x - R * rate(phi), "rolling"),
        ],
        inputs=[
            Torque("drive", on=axle, about=rear.y, limit=720.0),
            Torque("steer", on=steering, about=rear.z, limit=35.0, reacts_on=chassis),
        ],
        efforts=[Viscous(rate(phi), c_d), Viscous(rate(delta), c_s)],
        velocities=[delta, phi],
        flat=PlaneCurves(x, y, psi, steered=((delta, sympy.atan(L * CURVATURE)),)),
    )
