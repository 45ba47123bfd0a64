"""A snakeboard that a rotor moves, with a motor for each truck (after kinolab.systems)."""

from kinolab.dynamics import (
    Body,
    Box,
    Cylinder,
    Disk,
    System,
    Torque,
    Viscous,
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

WHEEL = 0.04  # [m] radius of the wheels
HEIGHT = 0.1  # [m] of the board above the ground


def steered_board() -> System:
    m, l = parameter("m", 6.0, "kg"), parameter("l", 0.2, "m")  # noqa: E741
    J_r, J_w = parameter("J_r", 0.072, "kg m^2"), parameter("J_w", 0.0013, "kg m^2")
    I_s = parameter("I_s", 4e-5, "kg m^2")  # of the back wheels about their axle
    c_r = parameter("c_r", 0.4, "N s/m")
    c_psi, c_phi = parameter("c_psi", 0.05, "N m s/rad"), parameter("c_phi", 0.01, "N m s/rad")
    x, y, theta = length("x"), length("y"), angle("theta")
    psi = angle("psi", speed=10.0)  # the rotor on the board
    back_phi = angle("back_phi", -1.0, 1.0, speed=4.0)  # the back truck
    front_phi = angle("front_phi", -1.0, 1.0, speed=4.0)  # the front truck
    s = angle("s", speed=40.0)  # rotation of the back wheels
    board = move(x, y, HEIGHT) @ rot_z(theta)
    back = board @ move(-l) @ rot_z(back_phi)
    front = board @ move(l) @ rot_z(front_phi)
    axle = Cylinder(0.012, 0.16, axis="y", at=(0, 0, WHEEL - HEIGHT))
    deck = Body("board", board, mass=m, inertia=m * (2 * l) ** 2 / 12, shape=Box(0.4, 0.1, 0.03))
    bar = (Cylinder(0.02, 0.3, at=(0, 0, 0.17)), Box(0.06, 0.4, 0.06, at=(0, 0, 0.32)))
    rotor = Body("rotor", board @ rot_z(psi), inertia=J_r, shape=bar)
    back_truck = Body("back truck", back, inertia=J_w, shape=axle)
    front_truck = Body(
        "front truck",
        front,
        inertia=J_w,
        shape=(axle, *_wheels(WHEEL - HEIGHT)),
        touches_ground=True,
    )
    spin = back @ move(0, 0, WHEEL - HEIGHT) @ rot_y(s)
    wheels = Body(
        "back wheels", spin, inertia=(I_s / 2, I_s, I_s / 2), shape=_wheels(), touches_ground=True
    )
    return System(
        "steered_board",
        bodies=[deck, rotor, back_truck, front_truck, wheels],
        constraints=[
            zero(velocity(back).y, "back wheels do not slip"),
            zero(velocity(front).y, "front wheels do not slip"),
            zero(velocity(back).x - WHEEL * rate(s), "back wheels roll"),
        ],
        inputs=[
            Torque("tau_psi", on=rotor, about=board.z, reacts_on=deck, limit=0.7),
            Torque("tau_back", on=back_truck, about=board.z, reacts_on=deck, limit=0.03),
            Torque("tau_front", on=front_truck, about=board.z, reacts_on=deck, limit=0.03),
        ],
        efforts=[
            Viscous(velocity(back).x, c_r),
            Viscous(velocity(front).x, c_r),
            Viscous(rate(psi), c_psi),
            Viscous(rate(back_phi), c_phi),
            Viscous(rate(front_phi), c_phi),
        ],
        velocities=[psi, back_phi, front_phi, s],
    )


def _wheels(z: float = 0.0) -> tuple[Disk, Disk]:
    left, right = (Disk(WHEEL, thickness=0.03, axis="y", at=(0, y, z)) for y in (0.08, -0.08))
    return left, right
