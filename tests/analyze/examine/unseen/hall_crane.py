"""An overhead crane whose rope swings both ways (a copy of kinolab.systems.crane)."""

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Cable,
    Cylinder,
    Force,
    Pull,
    System,
    Viscous,
    Wrench,
    angle,
    length,
    move,
    parameter,
    rate,
    require,
    rot_x,
    rot_y,
    toward,
)

HEIGHT = 9.0  # [m] of the rails above the floor
SPAN = 14.0  # [m] between the rails


def hall_crane() -> System:
    m, g = parameter("m", 1000.0, "kg"), parameter("g", 9.81, "m/s^2")
    M_b, M_t = parameter("M_b", 3000.0, "kg"), parameter("M_t", 500.0, "kg")
    c_x, c_y = parameter("c_x", 2500.0, "N s/m"), parameter("c_y", 1000.0, "N s/m")
    c_l, c_s = parameter("c_l", 2000.0, "N s/m"), parameter("c_s", 2000.0, "N m s/rad")
    x, y = length("x", speed=1.2), length("y", speed=1.2)
    l = length("l", 1.5, 8.2, speed=0.5)  # noqa: E741
    theta_x = angle("theta_x", -0.35, 0.35, speed=0.6)
    theta_y = angle("theta_y", -0.35, 0.35, speed=0.6)
    bridge = move(x, SPAN / 2, HEIGHT)
    rail = move(x, y, HEIGHT)
    rope = rail @ rot_y(-theta_x) @ rot_x(theta_y) @ move(0, 0, -l)
    beams = tuple(Box(0.3, SPAN, 0.5, at=(side, 0, 0.35)) for side in (-0.7, 0.7))
    drum = Cylinder(0.25, 0.8, axis="y", at=(0, 0, 0.45))
    load = Body("load", rope, mass=m, shape=Box(1.2, 1.2, 1.0))
    trolley = Body("trolley", rail, mass=M_t, shape=(Box(1.6, 1.0, 0.2, at=(0, 0, 0.7)), drum))
    girders = Body("bridge", bridge, mass=M_b, shape=beams)
    hoist = Pull("hoist", between=(rail, rope), limit=(8810.0, 10810.0))
    return System(
        "hall_crane",
        bodies=[load, trolley, girders],
        gravity=toward("-z", g),
        inputs=[
            Force("travel", on=girders, along=WORLD.x, limit=3000.0),
            Force("traverse", on=trolley, along=WORLD.y, limit=1200.0),
            hoist,
        ],
        efforts=[
            Viscous(rate(x), c_x),
            Wrench(on=trolley, force=(0, -c_y * rate(y), 0)),
            Viscous(rate(l), c_l),
            Viscous(rate(theta_x), c_s),
            Viscous(rate(theta_y), c_s),
        ],
        requirements=[require(hoist.symbol + c_l * rate(l), "the rope only pulls")],
        cables=[Cable((rail, rope), "rope", radius=0.03)],
    )
