"""A mobile robot on two driven wheels."""

from kinolab.dynamics import (
    Body,
    Box,
    Cylinder,
    Disk,
    Frame,
    Parameter,
    PlaneCurves,
    Sphere,
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


def diff_drive() -> System:
    """A robot whose two wheels each have a motor; it turns by driving them differently.

    Sizes and mass are those of a Pioneer 3-DX, rounded.

    Source: Laumond (ed.), Robot Motion Planning and Control, 1998, chapter 1.
    """
    # m and I_z are those of the whole robot, including the wheels' yaw inertia.
    m, I_z = parameter("m", 9.0, "kg"), parameter("I_z", 0.2, "kg m^2")
    r, b = parameter("r", 0.0975, "m"), parameter("b", 0.33, "m")
    I_w, c_w = parameter("I_w", 0.005, "kg m^2"), parameter("c_w", 0.08, "N m s/rad")
    x, y, psi = length("x"), length("y"), angle("psi")  # middle of the axle, heading
    phi_l, phi_r = angle("phi_l", speed=8.0), angle("phi_r", speed=8.0)  # [rad/s] of the wheels
    # The axle's frame: moved over the ground and turned about the vertical.
    axle = move(x, y, r) @ rot_z(psi)
    hull = (
        Box(0.40, 0.26, 0.16, at=(-0.03, 0, 0.08)),
        Cylinder(0.12, 0.04, at=(-0.03, 0, 0.18)),
        Sphere(0.03, at=(-0.2, 0, 0.03 - r)),  # the castor
    )
    robot = Body("robot", axle, mass=m, inertia=I_z - I_w, shape=hull, touches_ground=True)
    left = _wheel("left wheel", axle @ move(0, b / 2) @ rot_y(phi_l), r, I_w)
    right = _wheel("right wheel", axle @ move(0, -b / 2) @ rot_y(phi_r), r, I_w)
    # Constraints on velocities: the axle does not slip sideways, and both wheels roll.
    V = velocity(axle)
    turning = b / 2 * V.wz
    return System(
        "diff_drive",
        bodies=[robot, left, right],
        constraints=[
            zero(V.y, "no sideslip"),
            zero(V.x - turning - r * rate(phi_l), "left wheel rolls"),
            zero(V.x + turning - r * rate(phi_r), "right wheel rolls"),
        ],
        inputs=[
            Torque("left", on=left, reacts_on=robot, about=axle.y, limit=0.6),
            Torque("right", on=right, reacts_on=robot, about=axle.y, limit=0.6),
        ],
        efforts=[Viscous(rate(phi_l), c_w), Viscous(rate(phi_r), c_w)],
        velocities=[phi_l, phi_r],  # the independent ones
        flat=PlaneCurves(x, y, psi),  # planners may steer it along plane curves
    )


def _wheel(name: str, frame: Frame, radius: Parameter, spin_inertia: Parameter) -> Body:
    shape = Disk(radius, thickness=0.04, axis="y")
    return Body(
        name,
        frame,
        inertia=(spin_inertia / 2, spin_inertia, spin_inertia / 2),
        shape=shape,
        touches_ground=True,
    )
