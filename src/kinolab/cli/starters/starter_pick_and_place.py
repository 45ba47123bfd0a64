"""What ``plan new --pick-and-place`` writes: a hand on a gantry that takes a block over a wall."""

MACHINE = '''"""A machine of one's own: a hand on a gantry that picks up a block and puts it down.

Plan for it:     plan {name}.toml
Look at it:      plan view runs/{name}
"""

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Control,
    Force,
    Mode,
    System,
    Transition,
    Viscous,
    lag,
    length,
    move,
    parameter,
    rate,
    require,
    toward,
    zero,
)


def {name}() -> System:
    """A hand that moves in a vertical plane; a block lies on the table or hangs in the hand."""
    M, m = parameter("M", 1.0, "kg"), parameter("m", 0.3, "kg")  # hand, block
    g = parameter("g", 9.81, "m/s^2")
    x, z = length("x", -1.2, 1.2, speed=1.5), length("z", 0.0, 1.2, speed=1.5)  # of the hand
    bx, bz = length("bx", -1.2, 1.2, speed=1.5), length("bz", 0.0, 1.2, speed=1.5)  # of the block

    # The jaw follows what the planner asks of it, with a lag of 0.1 s: 1 is closed, -1 open.
    grip = Control("grip", limit=1.0)
    jaw = lag("jaw", grip.symbol, 0.1)

    palm = Box(0.16, 0.12, 0.04, at=(0, 0, 0.12))
    fingers = [Box(0.02, 0.1, 0.1, at=(side, 0, 0.05)) for side in (-0.07, 0.07)]
    hand = Body("hand", move(x, 0, z), mass=M, shape=(palm, *fingers))
    block = Body("block", move(bx, 0, bz), mass=m, shape=Box(0.1, 0.1, 0.1), touches_ground=True)

    # What holds in each mode. Held, the block moves as the hand does.
    lying = [zero(rate(bx), "block stays"), zero(rate(bz), "block lies")]
    held = [zero(rate(bx) - rate(x), "held along x"), zero(rate(bz) - rate(z), "held along z")]
    beside = (x - bx) ** 2 + (z - bz) ** 2  # [m^2]
    # The jaw takes what is within 8 cm; plans shall come within 4 cm, so that a hand that is a
    # little off still takes it.
    well = require(0.04**2 - beside, "block well in the hand")
    return System(
        "{name}",
        bodies=[hand, block],
        inputs=[
            Force("push", on=hand, along=WORLD.x, limit=8.0),
            Force("lift", on=hand, along=WORLD.z, limit=(0.0, 25.0)),
            grip,
        ],
        efforts=[Viscous(rate(x), 0.5), Viscous(rate(z), 0.5)],
        states=[jaw],
        gravity=toward("-z", g),
        modes=[
            Mode("lying", constraints=lying),
            Mode("held", constraints=held, requirements=[well]),
        ],
        # A mode lasts until an expression falls to zero, and only where `provided` is positive.
        transitions=[
            Transition(
                "grasp", "lying", "held", until=0.5 - jaw.symbol, provided=0.08**2 - beside
            ),
            Transition("release", "held", "lying", until=0.5 + jaw.symbol, provided=0.1 - bz),
        ],
    )
'''

TITLE = "A hand takes a block over a wall and puts it down"
SCENARIO = """
[world]
ground = "plane"
clearance = 0.02                        # [m] kept from the wall, for what is not as planned

[[world.obstacle]]
name = "wall"
box = [0.1, 0.4, 0.5]                   # [m] full edges
position = [0.0, 0.0, 0.25]             # [m] centre

[start]
x = -0.6
z = 0.5
bx = -0.6                               # the block lies below the hand
bz = 0.05

[goal]
bx = 0.6
bz = 0.05
mode = 0                                # "lying" again: the first mode
bx_dot = 0.0
bz_dot = 0.0
tolerance = {{ bx = 0.1, bz = 0.03, bx_dot = 0.1, bz_dot = 0.1, mode = 0.1 }}
reserve = 0.3                           # share of it that the plan leaves to the execution

[bounds]
jaw = [-1.0, 1.0]
lift = [0.0, 20.0]                      # of 25 N: the rest is left to correct errors with

[metric]                                # places matter most: who grasps must be where the block is
x = 5.0
z = 5.0

[planner]
time_limit = 60.0                       # [s]

[render]
view = "front"
"""
