"""A pendulum that swings up because a wheel at its end speeds up; x to the right, y up."""

from kinolab.dynamics import (
    Body, Capsule, Disk, System, Torque, Viscous, angle, move, parameter, rate, rot_z, toward,
)


def wheel_pendulum() -> System:
    """The motor sits at the end of the rod: what turns the wheel one way turns the rod the other."""
    m, w = parameter("m", 0.3, "kg"), parameter("w", 0.4, "kg")
    l, R = parameter("l", 0.3, "m"), parameter("R", 0.12, "m")
    theta = angle("theta", speed=10.0)  # 0 hangs
    spin = angle("spin", speed=200.0)  # of the wheel, relative to the rod
    rod = rot_z(theta)
    end = rod @ move(0, -l, 0)
    beam = Body(
        "rod", rod @ move(0, -l / 2, 0), mass=m, inertia=(m * l**2 / 12, 1e-5, m * l**2 / 12),
        shape=Capsule(0.01, l, axis="y"),
    )
    wheel = Body(
        "wheel", end @ move(0, 0, 0.03) @ rot_z(spin), mass=w, inertia=(w * R**2 / 2, w * R**2 / 2, w * R**2),
        shape=Disk(R, thickness=0.02, axis="z"),
    )
    return System(
        "wheel_pendulum",
        bodies=[beam, wheel],
        inputs=[Torque("motor", on=wheel, about=end.z, limit=2.5, reacts_on=beam)],
        efforts=[Viscous(rate(theta), 0.002)],
        gravity=toward("-y", 9.81),
    )
