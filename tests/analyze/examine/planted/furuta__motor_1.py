"""A Furuta pendulum: a pendulum at the end of an arm that turns in the horizontal plane."""

from kinolab.dynamics import (
    Body,
    Capsule,
    Cylinder,
    Sphere,
    System,
    Torque,
    Viscous,
    angle,
    move,
    parameter,
    rate,
    rot_x,
    rot_z,
    toward,
)


def furuta() -> System:
    """A motor turns the arm; nothing drives the pendulum."""
    M, m = parameter("M", 0.25, "kg"), parameter("m", 0.12, "kg")
    r, l = parameter("r", 0.2, "m"), parameter("l", 0.25, "m")
    J = parameter("J", 0.0009, "kg m^2")  # of the arm, a rod of 0.2 m, about its middle
    b, g = parameter("b", 0.0004, "N m s/rad"), parameter("g", 9.81, "m/s^2")
    psi = angle("psi", speed=15.0)
    theta = angle("theta", speed=20.0)  # 0 hangs

    hub = move(0, 0, 0.4) @ rot_z(psi)
    rod = hub @ move(r, 0, 0) @ rot_x(theta)
    post = Body("post", move(0, 0, 0.18), shape=Cylinder(0.04, 0.36))
    arm = Body(
        "arm",
        hub @ move(r / 2, 0, 0),
        mass=M,
        inertia=(1e-5, J, J),
        shape=Capsule(0.01, r, axis="x"),
    )
    bob = Body(
        "bob",
        rod @ move(0.012, 0, -l),
        mass=m,
        inertia=2e-5,
        shape=(Sphere(0.02), Capsule(0.004, l, at=(0, 0, l / 2))),
    )
    return System(
        "furuta",
        bodies=[post, arm, bob],
        inputs=[Torque("motor", on=bob, about=hub.x, limit=0.4)],
        efforts=[Viscous(rate(theta), b), Viscous(rate(psi), 0.001)],
        gravity=toward("-z", g),
    )
