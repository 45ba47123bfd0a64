"""A planar arm with two links on a robot with two driven wheels."""

from kinolab.dynamics import (
    Body,
    Box,
    Cylinder,
    System,
    Torque,
    Viscous,
    angle,
    length,
    move,
    rate,
    rot_y,
    rot_z,
    velocity,
    zero,
)


def mobile_arm() -> System:
    """A mobile manipulator: its wheels roll, its arm moves in a horizontal plane."""
    r, b, l = 0.1, 0.2, 0.4  # [m] radius of the wheels, half the track, length of a link  # noqa: E741
    x, y, psi = length("x"), length("y"), angle("psi")
    left, right = angle("left", speed=10.0), angle("right", speed=10.0)
    q1, q2 = angle("q1", -2.6, 2.6, speed=2.0), angle("q2", -2.6, 2.6, speed=2.0)
    axle = move(x, y, r) @ rot_z(psi)
    base = Body("base", axle, mass=15.0, inertia=0.4, shape=Box(0.5, 0.36, 0.2, at=(0, 0, 0.05)))
    wheel, I_w = Cylinder(r, 0.04, axis="y"), (0.005, 0.01, 0.005)
    L = Body("left wheel", axle @ move(0, b, 0) @ rot_y(left), mass=1.0, inertia=I_w, shape=wheel,
             touches_ground=True)  # fmt: skip
    R = Body("right wheel", axle @ move(0, -b, 0) @ rot_y(right), mass=1.0, inertia=I_w,
             shape=wheel, touches_ground=True)  # fmt: skip
    shoulder = axle @ move(0.15, 0, 0.2) @ rot_z(q1)
    elbow = shoulder @ move(l, 0, 0) @ rot_z(q2)
    link, I_a = Box(l, 0.06, 0.05), (0.001, 0.015, 0.015)
    upper = Body("upper arm", shoulder @ move(l / 2, 0, 0), mass=1.2, inertia=I_a, shape=link)
    fore = Body("forearm", elbow @ move(l / 2, 0, 0), mass=0.8, inertia=I_a, shape=link)
    V = velocity(axle)
    rolling = [zero(V.x - b * V.wz - r * rate(left), "left wheel rolls"),
               zero(V.x + b * V.wz - r * rate(right), "right wheel rolls")]  # fmt: skip
    return System("mobile_arm", bodies=[base, L, R, upper, fore], velocities=[left, right, q1, q2],
        constraints=[zero(V.y, "no sideslip"), *rolling],
        inputs=[Torque("drive_l", on=L, reacts_on=base, about=axle.y, limit=1.5),
                Torque("drive_r", on=R, reacts_on=base, about=axle.y, limit=1.5),
                Torque("shoulder", on=upper, reacts_on=base, about=shoulder.z, limit=3.0),
                Torque("elbow", on=fore, reacts_on=upper, about=elbow.z, limit=1.5)],
        efforts=[Viscous(rate(c), 0.1) for c in (left, right, q1, q2)])  # fmt: skip
