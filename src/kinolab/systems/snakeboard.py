"""A snakeboard: a board on two steered wheel pairs, moved by a rotor that turns back and forth."""

from kinolab.dynamics import (
    Body,
    Box,
    Control,
    Cylinder,
    Disk,
    System,
    Torque,
    Viscous,
    Wrench,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    rot_z,
    velocity,
    zero,
)

HALF = 0.2  # [m] half wheelbase of the shapes; the dynamics use the parameter l
WHEEL = 0.04  # [m] radius of the wheels
HEIGHT = 0.1  # [m] of the board above the ground
AXLE = Cylinder(0.012, 0.16, axis="y", at=(0, 0, WHEEL - HEIGHT))


def snakeboard() -> System:
    """A snakeboard: turning the rotor while the wheels are steered makes it roll.

    Both wheel pairs are steered together, the back one by phi, the front one by -phi, and roll
    without slipping sideways. The rate of the back wheels' rotation s is the board's speed
    coordinate at every heading; the front wheels' spin is negligible and left out.

    Source: Lewis, Ostrowski, Murray, Burdick, Nonholonomic mechanics and locomotion: the
    snakeboard example, ICRA 1994; masses as in Bullo, Lewis, Geometric Control of Mechanical
    Systems, 2004.
    """
    m, l = parameter("m", 6.0, "kg"), parameter("l", HALF, "m")  # noqa: E741
    J_r, J_w = parameter("J_r", 0.072, "kg m^2"), parameter("J_w", 0.0013, "kg m^2")
    I_s = parameter("I_s", 4e-5, "kg m^2")  # of the back wheels about their axle
    c_r = parameter("c_r", 0.4, "N s/m")  # of each wheel pair
    c_psi, c_phi = parameter("c_psi", 0.05, "N m s/rad"), parameter("c_phi", 0.01, "N m s/rad")
    x, y, theta = length("x"), length("y"), angle("theta")
    psi = angle("psi", speed=10.0)  # the rotor on the board
    phi = angle("phi", -1.0, 1.0, speed=4.0)  # the steering
    s = angle("s", speed=40.0)  # rotation of the back wheels
    board = move(x, y, HEIGHT) @ rot_z(theta)
    back, front = board @ move(-l) @ rot_z(phi), board @ move(l) @ rot_z(-phi)
    deck = Body(
        "board",
        board,
        mass=m,
        inertia=m * l**2 - J_r - 2 * J_w,
        shape=Box(0.36, 0.1, 0.03),
    )
    bar = (Cylinder(0.02, 0.3, at=(0, 0, 0.17)), Box(0.06, 0.4, 0.06, at=(0, 0, 0.32)))
    rotor = Body("rotor", board @ rot_z(psi), inertia=J_r, shape=bar)
    trucks = (
        Body("back truck", back, inertia=J_w - I_s / 2, shape=AXLE),
        Body(
            "front truck",
            front,
            inertia=J_w,
            shape=(AXLE, *_wheels(WHEEL - HEIGHT)),
            touches_ground=True,
        ),
    )
    spin = back @ move(0, 0, WHEEL - HEIGHT) @ rot_y(s)
    wheels = Body(
        "back wheels", spin, inertia=(I_s / 2, I_s, I_s / 2), shape=_wheels(), touches_ground=True
    )
    tau_phi = Control("tau_phi", limit=0.03, unit="N m")
    return System(
        "snakeboard",
        bodies=[deck, rotor, *trucks, wheels],
        constraints=[
            zero(velocity(back).y, "back wheels do not slip"),
            zero(velocity(front).y, "front wheels do not slip"),
            zero(velocity(back).x - WHEEL * rate(s), "back wheels roll"),
        ],
        inputs=[
            Torque("tau_psi", on=rotor, about=board.z, reacts_on=deck, limit=0.7),
            tau_phi,
        ],
        efforts=[
            *(
                Wrench(on=truck, torque=(0, 0, sign * tau_phi.symbol / 2), reacts_on=deck)
                for sign, truck in zip((1, -1), trucks, strict=True)
            ),
            Viscous(velocity(back).x, c_r),
            Viscous(velocity(front).x, c_r),
            Viscous(rate(psi), c_psi),
            Viscous(rate(phi), c_phi),
        ],
        velocities=[psi, phi, s],
    )


def _wheels(z: float = 0.0) -> tuple[Disk, Disk]:
    left, right = (Disk(WHEEL, thickness=0.03, axis="y", at=(0, y, z)) for y in (0.08, -0.08))
    return left, right
