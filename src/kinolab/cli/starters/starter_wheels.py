"""What ``plan new --wheels`` writes: a robot on two driven wheels."""

MACHINE = '''"""A machine of one's own: a robot on two driven wheels.

Plan for it:  plan {name}.toml
"""

from kinolab.dynamics import (
    Body,
    Box,
    Cylinder,
    PlaneCurves,
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


def {name}() -> System:
    """A robot with a motor at each wheel; it turns by driving them differently."""
    m, r, b = parameter("m", 8.0, "kg"), parameter("r", 0.1, "m"), parameter("b", 0.15, "m")
    x, y, psi = length("x"), length("y"), angle("psi")  # the middle of the axle, its heading
    left, right = angle("left", speed=8.0), angle("right", speed=8.0)  # [rad/s] of the wheels

    # The axle's frame: moved over the ground and turned about the vertical.
    axle = move(x, y, r) @ rot_z(psi)
    hull = Body("hull", axle, mass=m, inertia=m * 0.02, shape=Box(0.4, 0.24, 0.12, at=(0, 0, 0.03)))
    shape, spin = Cylinder(0.1, 0.04, axis="y"), (0.003, 0.005, 0.003)  # [m], [kg m^2]
    wheels = [
        Body(
            wheel, axle @ move(0, side, 0) @ rot_y(turn),
            mass=1.0, inertia=spin, shape=shape, touches_ground=True,
        )
        for wheel, side, turn in (("left wheel", b, left), ("right wheel", -b, right))
    ]

    # Constraints on velocities: the axle does not slip sideways, and both wheels roll.
    V = velocity(axle)
    return System(
        "{name}",
        bodies=[hull, *wheels],
        constraints=[
            zero(V.y, "no sideslip"),
            zero(V.x - b * V.wz - r * rate(left), "left wheel rolls"),
            zero(V.x + b * V.wz - r * rate(right), "right wheel rolls"),
        ],
        inputs=[
            Torque("drive_left", on=wheels[0], about=axle.y, limit=0.6),
            Torque("drive_right", on=wheels[1], about=axle.y, limit=0.6),
        ],
        efforts=[Viscous(rate(left), 0.05), Viscous(rate(right), 0.05)],
        velocities=[left, right],  # the independent ones
        flat=PlaneCurves(x, y, psi),  # planners may steer it along plane curves
    )
'''

SCENARIO = """schema = 1
title = "A robot drives round a wall"

[system]
file = "{name}.py:{name}"

[world]
bounds = {{ x = [0, 5], y = [0, 4] }}     # [m]
ground = "plane"

[[world.obstacle]]
name = "wall"
box = [0.2, 2.5, 0.5]                   # [m] full edges
position = [2.5, 1.25, 0.25]            # [m] centre

[start]
x = 1.0
y = 1.0

[goal]                                  # parked on the other side
x = 4.0
y = 1.0
at_rest = true
tolerance = 0.1                         # [m] and [rad/s]

[planner]
time_limit = 30.0                       # [s]
"""
