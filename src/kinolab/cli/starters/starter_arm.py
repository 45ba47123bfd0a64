"""What ``plan new --arm`` writes: an arm with two links."""

MACHINE = '''"""A machine of one's own: an arm with two links that moves up and down.

Plan for it:  plan {name}.toml
"""

from kinolab.dynamics import (
    Body,
    Box,
    System,
    Torque,
    Viscous,
    angle,
    move,
    parameter,
    rate,
    rot_y,
    toward,
)


def {name}() -> System:
    """Two links in a vertical plane, each with a motor strong enough to hold it."""
    m, l = parameter("m", 1.0, "kg"), parameter("l", 0.5, "m")  # of each link
    w = parameter("w", 0.05, "m")  # how wide it is; shapes follow parameters as frames do
    # Angles with limits, in rad, and the largest speed, in rad/s; 0 hangs straight down.
    shoulder = angle("shoulder", -3.0, 3.0, speed=3.0)
    elbow = angle("elbow", -2.5, 2.5, speed=3.0)

    # A joint is a frame: what follows it moves with it.
    upper_joint = move(0, 0, 1.2) @ rot_y(shoulder)
    lower_joint = upper_joint @ move(0, 0, -l) @ rot_y(elbow)
    across = m * (l**2 + w**2) / 12
    inertia = (across, across, m * w**2 / 6)  # about the centre of mass
    upper = Body(
        "upper arm", upper_joint @ move(0, 0, -l / 2),
        mass=m, inertia=inertia, shape=Box(w, w, l),
    )
    lower = Body(
        "forearm", lower_joint @ move(0, 1.2 * w, -l / 2),  # beside the upper arm
        mass=m, inertia=inertia, shape=Box(w, w, l),
    )
    return System(
        "{name}",
        bodies=[upper, lower],
        gravity=toward("-z", 9.81),
        inputs=[
            Torque("shoulder_motor", on=upper, about=upper_joint.y, limit=20.0),
            Torque("elbow_motor", on=lower, reacts_on=upper, about=lower_joint.y, limit=8.0),
        ],
        efforts=[Viscous(rate(shoulder), 0.2), Viscous(rate(elbow), 0.2)],
        # Bodies may pass through each other; the pairs that may not are named:
        # collisions=[("upper arm", "forearm")],
    )
'''

TITLE = "An arm reaches over a shelf"
SCENARIO = """
[world]
ground = "plane"
clearance = 0.02                        # [m] to spare: no real arm is quite as planned

[[world.obstacle]]
name = "shelf"
box = [0.4, 0.6, 0.05]                  # [m] full edges
position = [0.7, 0.0, 0.9]              # [m] centre

[start]                                 # it hangs at rest

[goal]                                  # the hand is above the shelf, at rest
at_rest = true
tolerance = 0.1                         # [rad/s]

[[goal.point]]
body = "forearm"
at = [0.0, 0.0, -0.25]                  # [m] the hand, in the frame of the forearm
position = [0.7, 0.06, 1.2]             # [m]
tolerance = 0.05

[bounds]                                # [N m] less than the motors can do: the rest corrects
shoulder_motor = [-16.0, 16.0]
elbow_motor = [-6.0, 6.0]

[planner]
time_limit = 30.0                       # [s]
"""
