"""A platform for cleaning windows, on two ropes from winches on the roof."""

from kinolab.dynamics import (
    Body,
    Box,
    Cable,
    Drive,
    Rope,
    System,
    angle,
    length,
    move,
    parameter,
    rot_y,
    toward,
)


def gondola() -> System:
    m, b, H = parameter("m", 240.0, "kg"), parameter("b", 3.0, "m"), parameter("H", 20.0, "m")
    k, d = parameter("k", 60000.0, "N/m"), parameter("d", 3000.0, "N s/m")
    g = parameter("g", 9.81, "m/s^2")
    x, z = length("x", -2.0, 2.0, speed=2.0), length("z", 0.6, 18.0, speed=2.0)
    tilt = angle("tilt", -0.6, 0.6, speed=1.0)
    l1, l2 = length("l1", 1.0, 20.0, speed=1.0), length("l2", 1.0, 20.0, speed=1.0)
    middle = move(x, 0, z) @ rot_y(tilt)
    deck = Body(
        "deck",
        middle,
        mass=m,
        inertia=(m * 0.3, m * b**2 / 12, m * b**2 / 12),
        shape=Box(b, 0.8, 1.0),
    )
    left, right = move(-b / 2, 0, H), move(b / 2, 0, H)
    hooks = middle @ move(-b / 2, 0, 0.5), middle @ move(b / 2, 0, 0.5)
    ropes = [
        Rope(between=(left, hooks[0]), stiffness=k, length=l1, damping=d),
        Rope(between=(right, hooks[1]), stiffness=k, length=l2, damping=d),
    ]
    return System(
        "gondola",
        bodies=[deck],
        gravity=toward("-z", g),
        efforts=ropes,
        inputs=[Drive("left_winch", on=l1, limit=0.5), Drive("right_winch", on=l2, limit=0.5)],
        cables=[Cable((left, hooks[0]), "left rope"), Cable((right, hooks[1]), "right rope")],
    )
