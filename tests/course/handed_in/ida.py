"""A trolley on rails with an electric motor: voltage in, current in the coil, torque on the wheels."""

from kinolab.dynamics import *


def trolley() -> System:
    m, r = parameter("m", 4.0, "kg"), parameter("r", 0.05, "m")
    k, L, Z = parameter("k", 0.4, "N m/A"), parameter("L", 0.05, "H"), parameter("Z", 2.0, "ohm")
    x, phi = length("x", -1.0, 6.0, speed=2.0), angle("phi", speed=40.0)
    theta = angle("theta", speed=8.0)
    rail = move(x, 0, r)
    body = Body("trolley", rail, mass=m, shape=Box(0.4, 0.2, 0.06, at=(0, 0, 0.06)))
    wheels = Body(
        "wheels",
        rail @ rot_y(phi),
        mass=0.5,
        inertia=(0.002, 0.0006, 0.002),
        shape=Cylinder(r, 0.2, axis="y"),
        touches_ground=True,
    )
    ball = Body("ball", rail @ move(0, 0.2, 1) @ rot_y(theta) @ move(0, 0, -0.6), mass=0.5, shape=Sphere(0.05))
    voltage, i = Control("voltage", limit=12.0, unit="V"), state("i")
    coil = State("i", (voltage.symbol - Z * i + k * rate(phi)) / L, limits=(-20, 20), unit="A")
    return System(
        "trolley",
        bodies=[body, wheels, ball],
        gravity=toward("-z"),
        constraints=[zero(rate(x) - r * rate(phi), "rolling")],
        inputs=[voltage],
        states=[coil],
        efforts=[
            Wrench(on=wheels, torque=(0, k * i, 0), reacts_on=body),
            Viscous(rate(phi), 0.01),
            Viscous(rate(theta), 0.02),
        ],
    )
