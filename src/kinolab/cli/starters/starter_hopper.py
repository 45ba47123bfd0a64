"""What ``plan new --hopper`` writes: a body on a springy leg that hops."""

MACHINE = '''"""A machine of one's own: a body on a springy leg that stands, hops and lands.

Plan for it:     plan {name}.toml
Let it bounce:   plan simulate {name}.py --start z=1.2
"""

from kinolab.dynamics import (
    WORLD,
    Body,
    Force,
    Mode,
    Potential,
    Sphere,
    System,
    Transition,
    Viscous,
    closed,
    force_of,
    length,
    move,
    parameter,
    rate,
    toward,
)


def {name}() -> System:
    """A body above a foot, with a spring and a motor between them."""
    M, m = parameter("M", 4.0, "kg"), parameter("m", 1.0, "kg")  # body, foot
    k, c = parameter("k", 600.0, "N/m"), parameter("c", 5.0, "N s/m")  # of the leg
    L, r = parameter("L", 0.6, "m"), parameter("r", 0.05, "m")  # leg at rest; the foot's radius
    g = parameter("g", 9.81, "m/s^2")
    z = length("z", 0.2, 3.0, speed=5.0)  # height of the body
    s = length("s", -0.35, 0.2, speed=6.0)  # how much longer the leg is than at rest

    body = Body("body", move(0, 0, z), mass=M, shape=Sphere(0.15))
    sole = move(0, 0, z - L - s)  # the middle of the foot
    foot = Body("foot", sole, mass=m, shape=Sphere(r), touches_ground=True)
    height = z - L - s - r  # of the foot above the ground

    # In stance the ground holds the foot, until the force that this takes falls to zero.
    standing = closed(height, "foot on the ground")
    return System(
        "{name}",
        bodies=[body, foot],
        efforts=[Potential(k * s**2 / 2), Viscous(rate(s), c)],
        # The motor in the leg pushes body and foot apart: the foot takes the reaction.
        inputs=[Force("leg", on=body, reacts_on=foot, along=WORLD.z, limit=60.0)],
        gravity=toward("-z", g),
        modes=[Mode("stance", constraints=[standing]), Mode("flight")],
        transitions=[
            Transition("lift off", "stance", "flight", until=force_of(standing)),
            Transition("land", "flight", "stance", until=height),
        ],
        keep=("L", "r"),  # what a ruler measures: `plan execute --parameters` leaves them alone
    )
'''

TITLE = "A hopper hops until it is high enough"
SCENARIO = """
[world]
ground = "plane"

[start]                                 # it stands, the spring carries the body
z = 0.5846
s = -0.0654

[goal]                                  # the top of a high hop: in the air, neither up nor down
z = 1.3
z_dot = 0.0
mode = 1                                # "flight", the second mode
tolerance = {{ z = 0.1, z_dot = 0.3, mode = 0.1 }}
reserve = 0.3                           # share of it that the plan leaves to the execution

[integration]
step = 0.02                             # [s]

[planner]
time_limit = 60.0                       # [s]
"""
