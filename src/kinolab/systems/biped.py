"""A biped in a plane that walks by the rates of its joints, one foot on the ground at a time."""

from __future__ import annotations

from kinolab.dynamics import (
    Body,
    Capsule,
    Frame,
    Mode,
    Rate,
    Sphere,
    System,
    Transition,
    angle,
    closed,
    homogeneous,
    length,
    move,
    rate,
    require,
    rot_y,
    zero,
)

THIGH, SHANK, SOLE = 0.45, 0.45, 0.06  # [m] of legs and round soles
TRUNK, NECK, HEAD = 0.45, 0.62, 0.11  # [m] length, and height and radius of the head
RED, BLUE, SKIN, DARK = (0.8, 0.3, 0.2), (0.25, 0.35, 0.6), (0.9, 0.75, 0.6), (0.25, 0.25, 0.28)


def biped() -> System:
    """A torso on two legs with hips and knees; its footsteps are part of a plan.

    The stance foot is held where it came down, at ``place``, and its leg turns about it, so that
    five rates, of the torso's lean and of four joints, determine every motion. A foot that comes
    down ends the mode and is the next one to stand. Hips swing legs ahead, knees bend them back.

    Source: Westervelt, Grizzle, Chevallereau, Choi, Morris, Feedback Control of Dynamic Bipedal
    Robot Locomotion, 2007, chapter 3 (stance and swing leg); sizes are those of a person.
    """
    x, z = length("x", -1.0, 20.0), length("z", 0.35, 1.2)
    place = length("place", -2.0, 21.0)  # of the foot that stands
    lean = angle("lean", -0.15, 0.8)
    torso = move(x, 0, z) @ rot_y(lean)
    bodies = [
        Body("torso", torso @ move(0, 0, 0.28), shape=Capsule(0.11, TRUNK - 0.15), color=RED),
        Body("head", torso @ move(0, 0, NECK), shape=Sphere(HEAD), color=SKIN),
    ]
    inputs, feet = [Rate("bend", on=rate(lean), limit=0.6)], {}
    for side, y in (("left", 0.2 / 2), ("right", -0.2 / 2)):  # [m] from hip to hip
        hip, knee = angle(f"hip_{side}", -0.9, 1.6), angle(f"knee_{side}", -2.2, 0.0)
        thigh = torso @ move(0, y, 0) @ rot_y(-hip)
        shank = thigh @ move(0, 0, -THIGH) @ rot_y(-knee)
        feet[side] = shank @ move(0, 0, -SHANK)
        bodies += _leg(side, thigh, shank, feet[side])
        inputs += [Rate(f"{joint.name}_rate", on=rate(joint), limit=2.5) for joint in (hip, knee)]
    ahead = {side: homogeneous(foot)[0, 3] for side, foot in feet.items()}
    height = {side: homogeneous(foot)[2, 3] - SOLE for side, foot in feet.items()}
    modes, transitions = [], []
    for side, other in (("left", "right"), ("right", "left")):
        stands = [
            closed(ahead[side] - place, f"{side} foot stays"),
            closed(height[side], f"{side} foot on the ground"),
        ]
        above = require(height[other], f"{other} foot above the ground")
        modes.append(Mode(side, constraints=stands, requirements=[above]))
        landed = {place: ahead[other]}
        transitions.append(
            Transition(f"{other} foot lands", side, other, until=height[other], reset=landed)
        )
    return System(
        "biped",
        bodies=bodies,
        constraints=[zero(rate(place), "footprint")],
        inputs=inputs,
        modes=modes,
        transitions=transitions,
    )


def _leg(side: str, thigh: Frame, shank: Frame, foot: Frame) -> list[Body]:
    middle = move(0, 0, -THIGH / 2)
    return [
        Body(f"{side} thigh", thigh @ middle, shape=Capsule(0.075, THIGH - 0.1), color=BLUE),
        Body(f"{side} shank", shank @ middle, shape=Capsule(0.05, SHANK - 0.16), color=SKIN),
        Body(f"{side} foot", foot, shape=Sphere(SOLE), touches_ground=True, color=DARK),
    ]
