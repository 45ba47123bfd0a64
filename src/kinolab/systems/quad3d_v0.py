"""The quadrotor of dynobench with four thrusts."""

from kinolab.dynamics import (
    Body,
    Control,
    Sphere,
    System,
    Wrench,
    length,
    move,
    orient,
    parameter,
    rotation,
    toward,
)

# Of each rotor: its position along x and y in units of a, and the sign of its drag torque.
ROTORS = ((1, -1, -1), (-1, -1, 1), (-1, 1, -1), (1, 1, 1))


def quad3d_v0() -> System:
    """A quadrotor of the size of a Crazyflie with four thrusts (dynobench).

    An input is a rotor's thrust relative to that in hover.

    Source: Ortiz-Haro and others, dynobench 0.0.4, models/quad3d_v0.yaml.
    """
    m, g = parameter("m", 0.034, "kg"), parameter("g", 9.81, "m/s^2")
    a = parameter("a", 0.707106781 * 0.046, "m")  # of a rotor along x and y
    t = parameter("t", 0.006, "m")  # a rotor's torque over its thrust
    inertia = (16.571710e-6, 16.655602e-6, 29.261652e-6)
    x, y, z = length("x", speed=4.0), length("y", speed=4.0), length("z", speed=4.0)
    R = rotation("R", speed=8.0)
    hull = Body("quadrotor", move(x, y, z) @ orient(R), mass=m, inertia=inertia, shape=Sphere(0.25))
    controls = [Control(f"f{k}", limit=(0.0, 1.3)) for k in range(1, 5)]
    thrusts = [control.symbol * m * g / 4 for control in controls]
    return System(
        "quad3d_v0",
        bodies=[hull],
        gravity=toward("-z", g),
        inputs=controls,
        efforts=[
            Wrench(
                on=hull, force=(0, 0, f), torque=(0, 0, turns * t * f), at=(ahead * a, aside * a, 0)
            )
            for f, (ahead, aside, turns) in zip(thrusts, ROTORS, strict=True)
        ],
    )
