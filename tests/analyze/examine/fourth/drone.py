"""A drone in a vertical plane on two rotors; exercise 12.2 of the course, with a shape."""

from kinolab.dynamics import Body, Box, Control, System, Wrench, angle, length, move, rot_y, toward


def drone() -> System:
    x, z, theta = length("x", speed=3.0), length("z", speed=3.0), angle("theta", speed=6.0)
    frame = move(x, 0, z) @ rot_y(theta)
    hull = Body("hull", frame, mass=0.8, inertia=(0.01, 0.01, 0.01), shape=Box(0.5, 0.5, 0.06))
    left, right = (
        Control("left", limit=(0.0, 8.0), unit="N"),
        Control("right", limit=(0.0, 8.0), unit="N"),
    )
    thrust, turn = left.symbol + right.symbol, 0.2 * (left.symbol - right.symbol)
    return System(
        "drone",
        bodies=[hull],
        inputs=[left, right],
        efforts=[Wrench(on=hull, force=(0, 0, thrust), torque=(0, turn, 0))],
        gravity=toward("-z"),
    )
