"""A planar biped as its user writes it: joint rates are given, one foot at a time is pinned."""

from kinolab.dynamics import (
    Body,
    Capsule,
    Mode,
    Rate,
    Sphere,
    System,
    Transition,
    angle,
    homogeneous,
    length,
    move,
    rate,
    require,
    rot_y,
    velocity,
    zero,
)

THIGH, SHANK, SOLE = 0.45, 0.45, 0.05  # m


def biped() -> System:
    """Torso, two legs with hip and knee, and round soles."""
    x, z = length("x", -1, 8), length("z", 0.3, 1.2)
    lean = angle("lean", -0.5, 0.5)
    torso, sides = move(x, 0, z) @ rot_y(lean), {"left": 0.09, "right": -0.09}
    bodies = [Body("torso", torso @ move(0, 0, 0.3), shape=Capsule(0.1, 0.4))]
    inputs, feet = [Rate("bend", on=rate(lean), limit=0.5)], {}
    for side, y in sides.items():
        hip, knee = angle(f"hip_{side}", -1.2, 1.2), angle(f"knee_{side}", -2.0, 0.0)
        thigh = torso @ move(0, y, 0) @ rot_y(-hip)
        shank = thigh @ move(0, 0, -THIGH) @ rot_y(-knee)
        feet[side] = shank @ move(0, 0, -SHANK)
        bodies += [
            Body(f"{side} thigh", thigh @ move(0, 0, -THIGH / 2), shape=Capsule(0.06, THIGH)),
            Body(f"{side} shank", shank @ move(0, 0, -SHANK / 2), shape=Capsule(0.045, 0.35)),
            Body(f"{side} foot", feet[side], shape=Sphere(SOLE), touches_ground=True),
        ]
        inputs += [
            Rate(f"{name}_{side}_rate", on=rate(joint), limit=2.5)
            for name, joint in (("hip", hip), ("knee", knee))
        ]
    height = {side: homogeneous(foot)[2, 3] - SOLE for side, foot in feet.items()}
    modes, transitions = [], []
    for side, other in (("left", "right"), ("right", "left")):
        V = velocity(feet[side])
        pinned = [zero(V.x, f"{side} foot along"), zero(V.z, f"{side} foot up")]
        above = require(height[other], f"{other} foot above the ground")
        modes.append(Mode(side, constraints=pinned, requirements=[above]))
        transitions.append(Transition(f"{other} foot lands", side, other, until=height[other]))
    return System("biped", bodies=bodies, inputs=inputs, modes=modes, transitions=transitions)
