"""Three links in a horizontal plane, each turned by a motor on the one before it."""

from kinolab.dynamics import WORLD, Body, Capsule, System, Torque, angle, move, parameter, rot_z


def three_links() -> System:
    m, l = parameter("m", 1.0, "kg"), parameter("l", 0.4, "m")
    a, b, c = (
        angle("a", speed=4.0),
        angle("b", -2.5, 2.5, speed=4.0),
        angle("c", -2.5, 2.5, speed=4.0),
    )
    inertia, shape = (0.001, m * l**2 / 12, m * l**2 / 12), Capsule(0.03, 0.34, axis="x")
    shoulder = move(0, 0, 0.5) @ rot_z(a)
    elbow = shoulder @ move(l) @ rot_z(b)
    wrist = elbow @ move(l) @ rot_z(c)
    upper = Body("upper", shoulder @ move(l / 2), mass=m, inertia=inertia, shape=shape)
    fore = Body("fore", elbow @ move(l / 2), mass=m, inertia=inertia, shape=shape)
    hand = Body("hand", wrist @ move(l / 2), mass=m, inertia=inertia, shape=shape)
    return System(
        "three_links",
        bodies=[upper, fore, hand],
        inputs=[
            Torque("first", on=upper, about=WORLD.z, limit=6.0),
            Torque("second", on=fore, about=fore.frame.z, limit=4.0, reacts_on=upper),
            Torque("third", on=hand, about=hand.frame.z, limit=2.0, reacts_on=upper),
        ],
    )
