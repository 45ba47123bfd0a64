"""A coin that rolls and leans."""

from kinolab.dynamics import (
    Body,
    Reference,
    Regulator,
    System,
    Torque,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_x,
    rot_y,
    rot_z,
    toward,
    velocity,
    zero,
)
from kinolab.systems._wheels import leaning_wheel

LEAN = 0.9  # [rad] at most
SPEED, TURN = (1.2, 3.5), 1.5  # [m/s], [rad/s] limits of its references; it needs some spin


def falling_disk() -> System:
    """A coin that rolls and may fall over; it keeps upright by steering into its lean.

    A lean theta > 0 is to the right. One torque acts about the axle, one about the line from the
    contact through the centre; what they react on is left out, as in the coin that cannot fall.
    Nothing pushes against the lean itself: only while the coin rolls at a spin s does turning at W
    tilt it, with the moment (A + m R^2) W s. A = k m R^2 and B = A / 2 are its moments of inertia
    about the axle and a diameter. If s^2 > B m g R / (A (A + m R^2)), which is g / (3 R) for a
    disk, it stays upright by itself. Its controller keeps it up at lower spins too, and follows a
    speed and a turn rate.

    Source: Neimark, Fufaev, Dynamics of Nonholonomic Systems, 1972.
    """
    m, R, g = parameter("m", 1.0, "kg"), parameter("R", 0.3, "m"), parameter("g", 9.81, "m/s^2")
    k = parameter("k", 0.5)  # A / (m R^2): 1/2 for a disk, 1 for a hoop
    x, y = length("x"), length("y")  # where it touches the ground
    psi = angle("psi", speed=6.0)  # heading
    theta = angle("theta", -LEAN, LEAN, speed=6.0)  # lean
    phi = angle("phi", speed=15.0)  # roll
    track = move(x, y) @ rot_z(psi)
    fork = track @ rot_x(theta) @ move(0, 0, R)  # leans with the coin, does not spin
    A = k * m * R**2
    coin = Body(
        "coin",
        fork @ rot_y(phi),
        mass=m,
        inertia=(A / 2, A, A / 2),
        shape=leaning_wheel(R, R / 12, LEAN),
        touches_ground=True,
    )
    V = velocity(track)
    speed = Reference("speed", limit=SPEED, unit="m/s")
    turn = Reference("turn", limit=TURN, unit="rad/s")
    law = Regulator(
        [speed, turn],
        tracked={theta: 0.2, rate(theta): 1.0, rate(psi): 2.0, rate(phi): 5.0},
        about={rate(phi): speed.symbol / R, rate(psi): turn.symbol},
        schedule={"speed": 4, "turn": 4},
    )
    return System(
        "falling_disk",
        bodies=[coin],
        gravity=toward("-z", g),
        constraints=[zero(V.y, "no sideslip"), zero(V.x - R * rate(phi), "rolling")],
        inputs=[
            Torque("drive", on=coin, about=fork.y, limit=1.0),
            Torque("steer", on=coin, about=fork.z, limit=0.5),
        ],
        velocities=[psi, theta, phi],
        feedback=law,
    )
