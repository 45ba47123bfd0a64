"""What ``plan new --flyer`` writes: a drone in a vertical plane."""

MACHINE = '''"""A machine of one's own: a drone with two rotors, in a vertical plane.

Plan for it:  plan {name}.toml
"""

from kinolab.dynamics import (
    Body,
    Box,
    Force,
    System,
    Viscous,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    toward,
)


def {name}() -> System:
    """A beam with a rotor at each end; rotors push up along the beam's own z axis."""
    m, l = parameter("m", 0.5, "kg"), parameter("l", 0.2, "m")  # l: from the middle to a rotor
    x, z = length("x", speed=3.0), length("z", speed=3.0)
    theta = angle("theta", -1.2, 1.2, speed=5.0)  # it leans, but does not turn over
    frame = move(x, 0, z) @ rot_y(theta)
    beam = Body("beam", frame, mass=m, inertia=m * l**2 / 3, shape=Box(2 * l, 0.1, 0.05))

    # A force acts on a body's centre of mass, so that each rotor is a body, here without mass.
    rotors = [
        Body(name, frame @ move(side, 0, 0.04), shape=Box(0.7 * l, 0.1, 0.02))
        for name, side in (("left rotor", -l), ("right rotor", l))
    ]
    return System(
        "{name}",
        bodies=[beam, *rotors],
        gravity=toward("-z", 9.81),
        inputs=[  # a rotor pushes one way only: 0 to 5 N, where half the weight is 2.5 N
            Force("left_thrust", on=rotors[0], along=frame.z, limit=(0.0, 5.0)),
            Force("right_thrust", on=rotors[1], along=frame.z, limit=(0.0, 5.0)),
        ],
        efforts=[Viscous(rate(x), 0.1), Viscous(rate(z), 0.1)],
    )
'''

TITLE = "A drone flies over a wall"
SCENARIO = """
[world]
bounds = {{ x = [0, 5], z = [0, 3] }}     # [m]
ground = "plane"
clearance = 0.08                        # [m] to spare: no real drone is quite as planned

[[world.obstacle]]
name = "wall"
box = [0.2, 1.0, 1.5]                   # [m] full edges
position = [2.5, 0.0, 0.75]             # [m] centre

[start]
x = 1.0
z = 0.8

[goal]                                  # it hovers on the other side
x = 4.0
z = 0.8
theta = 0.0
at_rest = true
tolerance = 0.1                         # [m], [rad], [m/s] and [rad/s]

[bounds]                                # [N] less than the rotors can do: the rest corrects
left_thrust = [0.5, 4.5]
right_thrust = [0.5, 4.5]

[planner]
time_limit = 30.0                       # [s]
"""
