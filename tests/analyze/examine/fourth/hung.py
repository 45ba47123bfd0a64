"""A stone on a rope that a winch reels in; docs/machines.md, Rope, with a shape and damping."""

from kinolab.dynamics import (
    WORLD,
    Body,
    Cable,
    Drive,
    Rope,
    Sphere,
    System,
    length,
    move,
    parameter,
    require,
    toward,
)


def hung() -> System:
    m, k = parameter("m", 2.0, "kg"), parameter("k", 5000.0, "N/m")
    c, g = parameter("c", 40.0, "N s/m"), parameter("g", 9.81, "m/s^2")
    z, l = length("z", -4.0, -0.2, speed=3.0), length("l", 0.5, 3.0, speed=1.0)  # noqa: E741
    stone = Body("stone", move(0, 0, z), mass=m, shape=Sphere(0.06))
    rope = Rope(between=(WORLD, stone.frame), stiffness=k, length=l, damping=c)
    return System(
        "hung",
        bodies=[stone],
        gravity=toward("-z", g),
        inputs=[Drive("reel", on=l, limit=1.0)],
        efforts=[rope],
        requirements=[require(500.0 - rope.tension, "the rope does not break")],
        cables=[Cable((WORLD, stone.frame), "rope")],
    )
