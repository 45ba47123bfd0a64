"""A pogo stick in a plane: a rider who leans by a reaction wheel, and a foot on a spring."""

from kinolab.dynamics import (
    Body,
    Box,
    Capsule,
    Disk,
    Mode,
    Pull,
    Sphere,
    Spring,
    System,
    Torque,
    Transition,
    Viscous,
    angle,
    closed,
    force_of,
    homogeneous,
    length,
    move,
    parameter,
    rate,
    rot_y,
    toward,
    velocity,
    zero,
)

REST = 0.8  # [m] from the rider's centre of mass to the foot, with the spring at rest


def pogo() -> System:
    m, m_f = parameter("m", 60.0, "kg"), parameter("m_f", 5.0, "kg")
    k, c = parameter("k", 10000.0, "N/m"), parameter("c", 60.0, "N s/m")
    J, g = parameter("J", 2.5, "kg m^2"), parameter("g", 9.81, "m/s^2")
    I_w = parameter("I_w", 0.4, "kg m^2")
    x, z = length("x", speed=6.0), length("z", 0.3, 3.0, speed=8.0)
    theta = angle("theta", -0.8, 0.8, speed=5.0)  # lean
    s = length("s", 0.5, 0.9, speed=8.0)  # from the rider to the foot
    phi = angle("phi", speed=60.0)  # the wheel in the rider's hands
    rider_frame = move(x, 0, z) @ rot_y(theta)
    foot_frame = rider_frame @ move(0, 0, -s)
    handles = rider_frame @ move(0.25, 0, 0.3) @ rot_y(-0.35)  # tilted towards the hands
    wheel_frame = rider_frame @ move(0, 0.25, 0.3) @ rot_y(phi)
    rider = Body(
        "rider",
        rider_frame,
        mass=m,
        inertia=J,
        shape=(Capsule(0.14, 0.6), Sphere(0.11, (0, 0, 0.5))),
    )
    foot = Body("foot", foot_frame, mass=m_f, inertia=0.05, shape=Sphere(0.03), touches_ground=True)
    bar = Body("handlebar", handles, shape=Box(0.03, 0.5, 0.03))
    wheel = Body("wheel", wheel_frame, mass=8.0, inertia=I_w, shape=Disk(0.3, 0.04, axis="y"))
    ground = closed(homogeneous(foot_frame)[2, 3], "the foot is on the ground")
    V = velocity(move(x, 0, z) @ rot_y(theta) @ move(0, 0, -s) @ rot_y(-theta))
    return System(
        "pogo",
        bodies=[rider, foot, bar, wheel],
        gravity=toward("-z", g),
        inputs=[
            Pull("legs", between=(rider_frame, foot_frame), limit=(-400.0, 400.0)),
            Torque("lean", on=wheel, about=rider_frame.y, limit=60.0, reacts_on=rider),
        ],
        efforts=[
            Spring(between=(rider_frame, foot_frame), stiffness=k, length=REST),
            Viscous(rate(s), c),
        ],
        modes=[
            Mode("stance", constraints=[ground, zero(V.x, "the foot does not slip")]),
            Mode("flight"),
        ],
        transitions=[
            Transition("lift off", "stance", "flight", until=force_of(ground)),
            Transition("land", "flight", "stance", until=homogeneous(foot_frame)[2, 3]),
        ],
    )
