"""A cart with an arm of two links."""

from kinolab.dynamics import *


def cart_arm() -> System:
    M, m, l = parameter("M", 6.0, "kg"), parameter("m", 1.0, "kg"), parameter("l", 0.5, "m")  # noqa: E741
    x = length("x", -3.0, 3.0, speed=2.0)
    q1, q2 = angle("q1", -2.5, 2.5, speed=4.0), angle("q2", -2.5, 2.5, speed=4.0)
    rail = move(x, 0, 1.5)
    shoulder = rail @ rot_y(q1)
    elbow = shoulder @ move(0, 0, -l) @ rot_y(q2)
    J = (m * l**2 / 12, m * l**2 / 12, 0)
    cart = Body("cart", rail, mass=M, shape=Box(0.4, 0.3, 0.2))
    upper = Body("upper arm", shoulder @ move(0, 0, -l / 2), mass=m, inertia=J, shape=Box(0.05, 0.05, l))
    fore = Body("forearm", elbow @ move(0, 0, -l / 2), mass=m, inertia=J, shape=Box(0.05, 0.05, l))
    return System(
        "cart_arm",
        bodies=[cart, upper, fore],
        gravity=toward("-z"),
        inputs=[
            Force("push", on=cart, along=WORLD.x, limit=40.0),
            Torque("shoulder", on=upper, about=rail.y, limit=20.0, reacts_on=cart),
            Torque("elbow", on=fore, about=shoulder.y, limit=8.0, reacts_on=upper),
        ],
        efforts=[Viscous(rate(x), 4.0), Viscous(rate(q1), 0.2), Viscous(rate(q2), 0.2)],
    )
