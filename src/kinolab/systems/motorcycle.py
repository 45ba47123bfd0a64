"""A motorcycle that leans into its turns."""

from __future__ import annotations

from kinolab.dynamics import (
    Body,
    Box,
    Capsule,
    Cylinder,
    Drive,
    Reference,
    Regulator,
    Sphere,
    System,
    Torque,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_x,
    rot_y,
    rot_z,
    toward,
    velocity,
    zero,
)
from kinolab.systems._wheels import leaning_wheel

LEAN = 0.8  # [rad] at most
SPEED, LEANS = (5.0, 12.0), 0.4  # [m/s], [rad] limits of the rider's references
BASE, AHEAD, HEIGHT = 1.4, 0.7, 0.65  # [m] of the shapes; the dynamics use b, c and p
WHEEL, TYRE = 0.3, 0.14  # [m] radius of the shapes (where it rolls, R) and width
RED, LEATHER = (0.78, 0.1, 0.12), (0.2, 0.25, 0.4)
RUBBER, STEEL = (0.13, 0.13, 0.15), (0.6, 0.62, 0.65)
FRAME = (  # tank, seat and fairing, about the centre of mass
    Capsule(0.13, 0.35, axis="x", at=(0.12, 0, 0.17)),
    Box(0.75, 0.2, 0.1, at=(-0.4, 0, 0.14)),
    Box(0.12, 0.3, 0.3, at=(0.46, 0, 0.3)),
)
ENGINE = (  # engine, swing arm and exhaust, about the centre of mass
    Box(0.5, 0.3, 0.34, at=(0, 0, -0.2)),
    Box(0.6, 0.24, 0.05, at=(-0.42, 0, WHEEL - HEIGHT)),
    Cylinder(0.05, 0.7, axis="x", at=(-0.35, -0.17, -0.27)),
)
FORK = (  # two tubes and a handlebar, about the front wheel's centre and along the fork
    *(Cylinder(0.025, 0.6, at=(0, side, 0.3)) for side in (-0.1, 0.1)),
    Cylinder(0.018, 0.72, axis="y", at=(-0.05, 0, 0.62)),
)
RIDER = (  # trunk, head, arms and thighs, about the saddle and along the trunk
    Capsule(0.14, 0.34, at=(0, 0, 0.27)),
    Sphere(0.13, at=(0.03, 0, 0.68)),
    *(
        shape
        for side in (-0.19, 0.19)
        for shape in (
            Capsule(0.045, 0.42, axis="x", at=(0.27, side, 0.45)),
            Capsule(0.07, 0.32, axis="x", at=(0.18, side, -0.02)),
        )
    ),
)


def motorcycle() -> System:
    """A motorcycle with its rider, a mass on a leaning plane that rolls on two points.

    The mass is p above and c ahead of the rear contact; the wheels, b apart, do not slip and weigh
    nothing. A lean alpha > 0 is to the right, a steering angle delta > 0 to the left; delta is the
    angle between the wheels' tracks on the ground. The drive turns the rear wheel against the
    frame. Steering is kinematic, as in the source: the wheel weighs nothing, so that no torque
    resists the handlebar. A jump of delta's rate would be an impact on the mass, which is thrown
    aside with the contact's track; hence the input is the steering angle's acceleration. The rider
    keeps a speed and a lean.

    Source: Getz, Marsden, Control for an autonomous bicycle, ICRA 1995.
    """
    m, g = parameter("m", 200.0, "kg"), parameter("g", 9.81, "m/s^2")
    p, c = parameter("p", HEIGHT, "m"), parameter("c", AHEAD, "m")
    b, R = parameter("b", BASE, "m"), parameter("R", WHEEL, "m")
    x, y, psi = length("x"), length("y"), angle("psi")  # rear contact, heading
    alpha = angle("alpha", -LEAN, LEAN, speed=2.0)  # lean
    delta = angle("delta", -0.6, 0.6, speed=1.5)  # steering
    phi = angle("phi", speed=70.0, scale=10.0)  # rotation of the wheels
    rear = move(x, y) @ rot_z(psi)
    front = rear @ move(b) @ rot_z(delta)
    plane = rear @ rot_x(alpha)
    hub, front_hub = (track @ rot_x(alpha) @ move(0, 0, R) for track in (rear, front))
    # 0.4 [rad] of the drawn fork; the model's steering axis is upright
    head = plane @ move(b, 0, R) @ rot_y(-0.4) @ rot_z(delta)
    saddle = plane @ move(AHEAD - 0.2, 0, HEIGHT + 0.2) @ rot_y(0.6)
    tyre = leaning_wheel(R, TYRE, LEAN)
    frame = Body("frame", plane @ move(c, 0, p), mass=m, shape=FRAME, color=RED)
    wheels = [
        Body(name, g @ rot_y(phi), shape=tyre, touches_ground=True, color=RUBBER)
        for name, g in (("rear wheel", hub), ("front wheel", front_hub))
    ]
    drawn = [
        Body("engine", plane @ move(c, 0, p), shape=ENGINE, color=STEEL),
        Body("fork", head, shape=FORK, color=STEEL),
        Body("rider", saddle, shape=RIDER, color=LEATHER),
    ]
    V = velocity(rear)
    speed = Reference("speed", limit=SPEED, unit="m/s")
    lean = Reference("lean", limit=LEANS, unit="rad")
    rider = Regulator(
        [speed, lean],
        tracked={alpha: 0.3, rate(alpha): 1.0, delta: 0.1, rate(delta): 0.5, rate(phi): 30.0},
        about={rate(phi): speed.symbol / R, alpha: lean.symbol},
        efforts={"steer": 5.0},
        schedule={"speed": 5, "lean": 4},
    )
    return System(
        "motorcycle",
        bodies=[frame, *wheels, *drawn],
        gravity=toward("-z", g),
        constraints=[
            zero(V.y, "no sideslip behind"),
            zero(velocity(front).y, "no sideslip in front"),
            zero(V.x - R * rate(phi), "rolling"),
        ],
        inputs=[
            Torque("drive", on=wheels[0], about=hub.y, reacts_on=frame, limit=300.0),
            Drive("steer", on=delta, limit=15.0),
        ],
        velocities=[alpha, delta, phi],
        feedback=rider,
    )
