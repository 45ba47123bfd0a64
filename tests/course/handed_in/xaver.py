"""An elevator: cabin and counterweight hang on a rope over a sheave that a motor turns."""

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Disk,
    System,
    Torque,
    Viscous,
    angle,
    closed,
    length,
    move,
    parameter,
    rate,
    rot_y,
    toward,
)


def counterweight() -> System:
    M, W = parameter("M", 900.0, "kg"), parameter("W", 1100.0, "kg")
    S, R = parameter("S", 120.0, "kg"), parameter("R", 0.4, "m")
    c, H = parameter("c", 60.0, "N s/m"), parameter("H", 30.0, "m")
    up, down = length("up", 1.2, 26.0, speed=3.0), length("down", 1.2, 26.0, speed=3.0)
    phi = angle("phi", -100.0, 100.0, speed=10.0)
    cabin = Body("cabin", move(-R, 0, up), mass=M, shape=Box(0.7, 1.6, 2.2))
    counterweight = Body("counterweight", move(R, 0, down), mass=W, shape=Box(0.3, 1.0, 1.5))
    sheave = Body(
        "sheave",
        move(0, 0, H) @ rot_y(phi),
        mass=S,
        inertia=(S * R**2 / 4, S * R**2 / 2, S * R**2 / 4),
        shape=Disk(R, thickness=0.15, axis="y"),
    )
    rope = closed(up + down - 27.2, "the rope keeps its length")
    grip = closed(up - 2 - R * phi, "the rope does not slip")
    return System(
        "elevator",
        bodies=[cabin, counterweight, sheave],
        constraints=[rope, grip],
        inputs=[Torque("motor", on=sheave, about=WORLD.y, limit=2500.0)],
        efforts=[Viscous(rate(up), c), Viscous(rate(down), c)],
        gravity=toward("-z"),
        cables=[(move(-R, 0, H), cabin.frame), (move(R, 0, H), counterweight.frame)],
    )
