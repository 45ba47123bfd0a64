"""A ball that a magnet holds below itself."""

from kinolab.dynamics import Body, Control, Sphere, System, Wrench, length, move, parameter, toward


def magnet() -> System:
    """s is the gap; the force grows as the gap closes, and so the ball does not hang by itself."""
    m, C = parameter("m", 0.1, "kg"), parameter("C", 0.009, "N m^2/A")
    s = length("s", speed=1.0)
    ball = Body("ball", move(0, 0, 1.0 - s), mass=m, shape=Sphere(0.01))
    current = Control("current", limit=(0.0, 4.0), unit="A")
    pull = Wrench(on=ball, force=(0, 0, C * current.symbol / s**2))
    return System("magnet", bodies=[ball], inputs=[current], efforts=[pull], gravity=toward("-z", 9.81))
