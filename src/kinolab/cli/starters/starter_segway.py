"""What ``plan new --segway`` writes: a body on two wheels that balances by feedback."""

MACHINE = '''"""A machine of one's own: a body above two driven wheels, which balances by feedback.

Plan for it:     plan {name}.toml
Is it robust?    plan execute runs/{name} --parameters 0.05
"""

from kinolab.dynamics import (
    Body,
    Box,
    Disk,
    Reference,
    Regulator,
    System,
    Torque,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    rot_z,
    toward,
    velocity,
    zero,
)


def {name}() -> System:
    """A body above an axle, between two wheels with a motor each."""
    M, m = parameter("M", 5.0, "kg"), parameter("m", 0.5, "kg")  # body, each wheel
    R, b = parameter("R", 0.1, "m"), parameter("b", 0.3, "m")  # of the wheels; between them
    l, g = parameter("l", 0.35, "m"), parameter("g", 9.81, "m/s^2")  # l: axle to centre of mass
    x, y = length("x", speed=2.0), length("y", speed=2.0)
    psi = angle("psi", speed=4.0)  # heading
    theta = angle("theta", -0.7, 0.7, speed=4.0)  # lean, 0 upright
    left, right = angle("left", speed=25.0), angle("right", speed=25.0)  # turns of the wheels

    axle = move(x, y, R) @ rot_z(psi)
    body = Body(
        "body", axle @ rot_y(theta) @ move(0, 0, l),
        mass=M, inertia=(0.20, 0.18, 0.05), shape=Box(0.12, 0.22, 0.5),
    )

    # A shape whose size is the frame's height: with a larger radius the axle rises with the wheel.
    def wheel(name, side, turn):
        return Body(
            name, axle @ move(0, side, 0) @ rot_y(turn),
            mass=m, inertia=(m * R**2 / 4, m * R**2 / 2, m * R**2 / 4),
            shape=Disk(R, thickness=0.03, axis="y"), touches_ground=True,
        )

    wheels = wheel("left wheel", b / 2, left), wheel("right wheel", -b / 2, right)
    V = velocity(axle)
    ahead_left, ahead_right = V.x - b / 2 * V.wz, V.x + b / 2 * V.wz  # speeds of the hubs

    # Upright it falls, so that its controller is part of it: kinolab designs the gains from what
    # counts as a large deviation, and the planner chooses the references.
    speed = Reference("speed", limit=1.2, unit="m/s")
    turning = Reference("turning", limit=1.5, unit="rad/s")
    balance = Regulator(
        [speed, turning],
        tracked={{theta: 0.3, rate(theta): 3.0, R * rate(left): 1.0, R * rate(right): 1.0}},
        about={{
            R * rate(left): speed.symbol - b / 2 * turning.symbol,
            R * rate(right): speed.symbol + b / 2 * turning.symbol,
        }},
    )
    return System(
        "{name}",
        bodies=[body, *wheels],
        constraints=[
            zero(V.y, "no sideslip"),
            zero(ahead_left - R * rate(left), "left wheel rolls"),
            zero(ahead_right - R * rate(right), "right wheel rolls"),
        ],
        # The motors sit on the body, which takes the reaction: this is how it balances.
        inputs=[
            Torque("left_motor", on=wheels[0], reacts_on=body, about=axle.y, limit=4.0),
            Torque("right_motor", on=wheels[1], reacts_on=body, about=axle.y, limit=4.0),
        ],
        gravity=toward("-z", g),
        feedback=balance,
    )
'''

TITLE = "A Segway drives round a pillar and stops upright"
SCENARIO = """
[world]
bounds = {{ x = [-1, 5], y = [-2, 2] }}   # [m]
ground = "plane"
clearance = 0.08                        # [m] kept from obstacles, for what is not as planned

[[world.obstacle]]
name = "pillar"
cylinder = [0.3, 1.5]                   # [m] radius and height
position = [2.0, 0.0, 0.75]             # [m] centre

[start]                                 # it stands upright at rest

[goal]
x = 4.0
y = 0.0
theta = 0.0
at_rest = true
reserve = 0.3                           # share of tolerances that the plan leaves to the execution

[goal.tolerance]                        # what is left out: 0.1
x = 0.15                                # [m]
y = 0.15
theta = 0.15                            # [rad]
theta_dot = 0.15                        # [rad/s]
left_dot = 0.5                          # of a wheel: 0.05 m/s, as it balances to and fro
right_dot = 0.5

[bounds]                                # of the 1.2 m/s there are: the rest is the law's own
speed = [-1.0, 1.0]                     # [m/s]

[integration]
step = 0.025                            # [s] the law looks at the machine this often

[planner]
time_limit = 60.0                       # [s]
"""
