"""What ``plan new`` writes without an option: a puck on an air table."""

MACHINE = '''"""A machine of one's own: a puck on an air table, pushed by two fans.

Look at it:   plan equations {name}.py
Let it move:  plan simulate {name}.py --start x_dot=0.5
Examine it:   plan examine {name}.py
Plan for it:  plan {name}.toml
"""

from kinolab.dynamics import (
    WORLD,
    Body,
    Cylinder,
    Force,
    System,
    Viscous,
    length,
    move,
    parameter,
    rate,
)


def {name}() -> System:
    """A puck on an air table."""
    # Parameters are symbols: equations show their names, and new values compile nothing.
    m = parameter("m", 0.5, "kg")
    b = parameter("b", 0.1, "N s/m")
    r, h = parameter("r", 0.15, "m"), parameter("h", 0.1, "m")  # its radius and its height

    # Coordinates know their unit and how fast they may change, in m/s.
    x, y = length("x", speed=1.0), length("y", speed=1.0)

    # A frame is a product of motions: move(x, y, z), rot_x, rot_y, rot_z. It needs no body.
    center = move(x, y, h / 2)

    # A body's centre of mass is the origin of its frame; its shape is what may not collide,
    # and follows the parameters, too.
    puck = Body("puck", center, mass=m, shape=Cylinder(r, h), touches_ground=True)

    return System(
        "{name}",
        bodies=[puck],
        # What the planner decides, with limits in N. The axis says whose direction is meant.
        inputs=[
            Force("fan_x", on=puck, along=WORLD.x, limit=0.5),
            Force("fan_y", on=puck, along=WORLD.y, limit=0.5),
        ],
        # What acts besides: here a little drag in each direction.
        efforts=[Viscous(rate(x), b), Viscous(rate(y), b)],
        # Bodies may pass through each other; the pairs that may not are named:
        # collisions=[("puck", "other body")],
        # Constraints, springs, gravity, further bodies: `plan help machine` has every word.
    )
'''

TITLE = "A puck crosses an air table"
SCENARIO = """parameters = {{ m = 0.5 }}                # [kg]

[world]
bounds = {{ x = [0, 3], y = [0, 2] }}     # [m]
ground = "plane"

[[world.obstacle]]                      # also: mesh = "file.stl", sphere, cylinder
name = "block"
box = [0.2, 1.4, 0.3]                   # [m] full edges
position = [1.5, 0.7, 0.15]             # [m] centre

[start]                                 # what is left out is 0
x = 0.5
y = 0.5

[goal]                                  # what is left out is free
x = 2.5
y = 0.5
tolerance = 0.1                         # [m]

[planner]                               # left out, the planner is "auto"
time_limit = 20.0                       # [s]
"""
