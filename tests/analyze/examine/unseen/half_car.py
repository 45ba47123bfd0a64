"""A car on its suspension, seen from the side."""

from sympy import cos

from kinolab.dynamics import (
    Body,
    Box,
    Disk,
    Pull,
    Spring,
    System,
    Viscous,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    toward,
)


def half_car() -> System:
    """A body that heaves and pitches on two axles, each on the spring of its tyres.

    Heights are above the road. Two actuators beside the springs make the suspension an active one.

    Source: Rajamani, Vehicle Dynamics and Control, 2nd ed., 2012, chapters 10 and 11.
    """
    M, J = parameter("M", 600.0, "kg"), parameter("J", 1000.0, "kg m^2")
    m_w, g = parameter("m_w", 40.0, "kg"), parameter("g", 9.81, "m/s^2")
    a, b = (
        parameter("a", 1.2, "m"),
        parameter("b", 1.4, "m"),
    )  # from the centre of mass to the axles
    k_f, k_r = parameter("k_f", 21000.0, "N/m"), parameter("k_r", 18000.0, "N/m")
    c_f, c_r = parameter("c_f", 1500.0, "N s/m"), parameter("c_r", 1300.0, "N s/m")
    k_t, R = parameter("k_t", 180e3, "N/m"), parameter("R", 0.32, "m")  # of a tyre
    l_s = parameter("l_s", 0.45, "m")  # length of an unloaded spring
    z = length("z", 0.4, 0.8, speed=2.0)  # of the centre of mass
    theta = angle("theta", -0.15, 0.15, speed=1.0)  # pitch, nose down
    z_f, z_r = length("z_f", 0.2, 0.4, speed=3.0), length("z_r", 0.2, 0.4, speed=3.0)
    chassis = move(0, 0, z) @ rot_y(theta)
    front_mount, rear_mount = chassis @ move(a), chassis @ move(-b)
    front_hub, rear_hub = move(a, 0, z_f), move(-b, 0, z_r)
    front_road, rear_road = move(a), move(-b)
    body = Body("body", chassis, mass=M, inertia=J, shape=Box(4.4, 1.6, 0.5, at=(0, 0, 0.25)))
    front = Body("front axle", front_hub, mass=m_w, shape=Disk(0.28, 0.2, axis="y"))
    rear = Body("rear axle", rear_hub, mass=m_w, shape=Disk(0.28, 0.2, axis="y"))
    return System(
        "half_car",
        bodies=[body, front, rear],
        gravity=toward("-z", g),
        inputs=[
            Pull("front_actuator", between=(front_mount, front_hub), limit=(-1500.0, 1500.0)),
            Pull("rear_actuator", between=(rear_mount, rear_hub), limit=(-1500.0, 1500.0)),
        ],
        efforts=[
            Spring(between=(front_mount, front_hub), stiffness=k_f, length=l_s),
            Spring(between=(rear_mount, rear_hub), stiffness=k_r, length=l_s),
            Spring(between=(front_hub, front_road), stiffness=k_t, length=R),
            Spring(between=(rear_hub, rear_road), stiffness=k_t, length=R),
            Viscous(rate(z) - a * cos(theta) * rate(theta) - rate(z_f), c_f),
            Viscous(rate(z) + b * cos(theta) * rate(theta) - rate(z_r), c_r),
        ],
    )
