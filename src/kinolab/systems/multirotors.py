"""The multirotors of dynobench, in a vertical plane and in space."""

from sympy import Expr

from kinolab.dynamics import (
    Body,
    Box,
    Control,
    Sphere,
    System,
    Wrench,
    angle,
    length,
    move,
    orient,
    parameter,
    rot_z,
    rotation,
    toward,
)

# Of each rotor in space: its position along x and y in units of a, and the sign of its drag torque.
ROTORS = ((1, -1, -1), (-1, -1, 1), (-1, 1, -1), (1, 1, 1))


def quad2d_v0() -> System:
    """A multirotor in a vertical plane, of the size of a Crazyflie (dynobench).

    An input is a rotor's thrust relative to that in hover.

    Source: Ortiz-Haro and others, dynobench 0.0.4, models/quad2d_v0.yaml.
    """
    m, I = parameter("m", 0.034, "kg"), parameter("I", 1e-4, "kg m^2")  # noqa: E741
    g = parameter("g", 9.81, "m/s^2")
    l = parameter("l", 0.1, "m")  # noqa: E741  # centre to rotor
    x, y, theta = length("x", speed=4.0), length("y", speed=4.0), angle("theta", speed=8.0)
    hull = move(x, y) @ rot_z(theta)
    rotor = Body("rotor", hull, mass=m, inertia=I, shape=Box(0.6, 0.2, 0.2))
    return _in_the_plane("quad2d_v0", [rotor], 1.3, m * g, l, g)


def quad2dpole_v0() -> System:
    """A multirotor in a vertical plane that carries a point mass on a rod (dynobench).

    An input is a rotor's thrust relative to that in hover of the multirotor alone. The pole hangs
    at q = 0, measured from the multirotor.

    Source: Ortiz-Haro and others, dynobench 0.0.4, models/quad2dpole_v0.yaml.
    """
    m, m_p = parameter("m", 2.5, "kg"), parameter("m_p", 0.25, "kg")
    I, g = parameter("I", 1.2, "kg m^2"), parameter("g", 9.81, "m/s^2")  # noqa: E741
    l, r = parameter("l", 0.25, "m"), parameter("r", 1.0, "m")  # noqa: E741  # to a rotor, to the mass
    x, y = length("x", speed=3.0), length("y", speed=3.0)
    theta, q = angle("theta", -1.570796, 1.570796, speed=5.0), angle("q", speed=5.0)
    hull = move(x, y) @ rot_z(theta)
    rotor = Body("rotor", hull, mass=m, inertia=I, shape=Box(0.5, 0.25, 0.2))
    pole = Body(
        "pole", hull @ rot_z(q) @ move(0, -r), mass=m_p, shape=Box(0.1, r, 0.1, at=(0, r / 2, 0))
    )
    return _in_the_plane("quad2dpole_v0", [rotor, pole], 3.0, m * g, l, g)


def _in_the_plane(
    name: str, bodies: list[Body], most: float, weight: Expr, arm: Expr, g: Expr
) -> System:
    """Return a machine whose first body has two rotors, each for half of a weight in hover."""
    controls = Control("f1", limit=(0.0, most)), Control("f2", limit=(0.0, most))  # right, left
    return System(
        name,
        bodies=bodies,
        gravity=toward("-y", g),
        inputs=controls,
        efforts=[
            Wrench(on=bodies[0], force=(0, f.symbol * weight / 2, 0), at=(side, 0, 0))
            for f, side in zip(controls, (arm, -arm), strict=True)
        ],
    )


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


def quad3d_omplapp() -> System:
    """A quadrotor with one thrust and three torques, as in OMPL.app (dynobench).

    The thrust is relative to the weight, the torques are relative to T.

    Source: Ortiz-Haro and others, dynobench 0.0.4, models/quad3d_omplapp.yaml.
    """
    m, g = parameter("m", 1.0, "kg"), parameter("g", 9.81, "m/s^2")
    J, T = parameter("J", 1.0, "kg m^2"), parameter("T", 20.0, "N m")
    x, y, z = length("x", speed=4.0), length("y", speed=4.0), length("z", speed=4.0)
    R = rotation("R", speed=8.0)
    hull = Body("quadrotor", move(x, y, z) @ orient(R), mass=m, inertia=J, shape=Sphere(0.25))
    lift = Control("f", limit=(0.0, 1.5))
    turns = [Control(name, limit=2.0) for name in ("tx", "ty", "tz")]
    wrench = Wrench(
        on=hull,
        force=(0, 0, lift.symbol * m * g),
        torque=(turns[0].symbol * T, turns[1].symbol * T, turns[2].symbol * T),
    )
    return System(
        "quad3d_omplapp",
        bodies=[hull],
        gravity=toward("-z", g),
        inputs=[lift, *turns],
        efforts=[wrench],
    )
