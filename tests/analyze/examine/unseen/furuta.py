"""A rotary pendulum, as laboratories have it."""

from kinolab.dynamics import (
    Body,
    Capsule,
    Control,
    Cylinder,
    System,
    Viscous,
    Wrench,
    angle,
    move,
    parameter,
    rate,
    rot_x,
    rot_z,
    toward,
)

THICK = 0.006  # [m] radius of arm and rod


def furuta() -> System:
    """A motor turns an arm about the vertical; at its end a rod swings about the arm's axis.

    The rod hangs at beta = 0. The motor is given by its voltage u: its torque is k (u - k w) / R.

    Source: Cazzolato, Prime, On the dynamics of the Furuta pendulum, J. Control Science and
    Engineering, 2011.
    """
    m_a, L_a = parameter("m_a", 0.25, "kg"), parameter("L_a", 0.22, "m")
    m_p, L_p = parameter("m_p", 0.13, "kg"), parameter("L_p", 0.34, "m")
    c_a, c_p = parameter("c_a", 2e-3, "N m s/rad"), parameter("c_p", 1e-4, "N m s/rad")
    k, R = parameter("k", 0.5, "N m/A"), parameter("R", 2.6, "V/A")
    g = parameter("g", 9.81, "m/s^2")
    alpha, beta = angle("alpha", speed=15.0), angle("beta", speed=30.0)
    turned = move(0, 0, 0.4) @ rot_z(alpha)
    hinge = turned @ move(L_a)
    I_a, I_p, r = m_a * L_a**2 / 12, m_p * L_p**2 / 12, THICK
    arm = Body(
        "arm",
        turned @ move(L_a / 2),
        mass=m_a,
        inertia=(m_a * r**2 / 2, I_a, I_a),
        shape=Capsule(r, L_a, axis="x"),
    )
    rod = Body(
        "rod",
        hinge @ rot_x(beta) @ move(0, 0, -L_p / 2),
        mass=m_p,
        inertia=(I_p, I_p, m_p * r**2 / 2),
        shape=Capsule(r, L_p, axis="z"),
    )
    column = Body("column", move(0, 0, 0.2), shape=Cylinder(0.03, 0.4), touches_ground=True)
    voltage = Control("voltage", limit=10.0, unit="V")
    return System(
        "furuta",
        bodies=[arm, rod, column],
        gravity=toward("-z", g),
        inputs=[voltage],
        efforts=[
            Wrench(on=arm, torque=(0, 0, k * (voltage.symbol - k * rate(alpha)) / R)),
            Viscous(rate(alpha), c_a),
            Viscous(rate(beta), c_p),
        ],
    )
