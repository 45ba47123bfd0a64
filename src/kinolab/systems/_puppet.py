"""A puppet's body: torso, head, arms and legs, and where strings are hooked into it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from kinolab.dynamics import (
    Body,
    Box,
    Capsule,
    Coordinate,
    Cylinder,
    Frame,
    Sphere,
    Viscous,
    angle,
    length,
    move,
    orient,
    parameter,
    rate,
    rot_x,
    rot_y,
    rot_z,
    rotation,
)

Triple: TypeAlias = tuple[float, float, float]

SIDES = (("l", 1), ("r", -1))  # left is +y: the puppet looks along +x
ARM, LEG = 1.5, 2.0  # [m] length of each link of an arm and of a leg
NECK, SHOULDER, HIP = 2.2, (0.0, 1.2, 1.2), (0.0, 0.6, -1.5)  # [m] from the torso's centre
SKIN, RED, GOLD = (0.93, 0.76, 0.62), (0.75, 0.16, 0.18), (0.9, 0.72, 0.3)
BLUE, BROWN, DARK, WHITE = (0.2, 0.3, 0.55), (0.36, 0.22, 0.14), (0.12, 0.12, 0.14), (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class PuppetBody:
    """What a machine with a puppet in it is made of.

    Attributes:
        place: Coordinates of the torso along x, y and z.
        bodies: Torso, head, limbs, and what they wear.
        joints: Friction of every joint.
        hooks: Where strings are hooked in: ``shoulder_l``, ``hand_l``, ``knee_l``, and right ones.
    """

    place: tuple[Coordinate, Coordinate, Coordinate]
    bodies: tuple[Body, ...]
    joints: tuple[Viscous, ...]
    hooks: dict[str, Frame]


def puppet_body() -> PuppetBody:
    """Return a puppet of 22 coordinates: a torso that is free in space, and four limbs of 3 + 1.

    A limb swings about y, spreads about x and twists about z at its root, in this order, and bends
    about y at its elbow or knee; links hang along -z where all angles are 0.

    Source: Johnson, Murphey, Dynamic modeling and motion planning for marionettes: rigid bodies
    articulated by massless strings, ICRA 2007.
    """
    x, y, z = length("x", speed=3.0), length("y", speed=3.0), length("z", speed=3.0)
    torso = move(x, y, z) @ orient(rotation("R", speed=5.0))
    bodies, joints, hooks = _trunk(torso), [], {}
    for side, sign in SIDES:
        # The left hook [m].
        hooks[f"shoulder_{side}"] = torso @ move(*_mirrored((0.0, 1.0, 1.5), sign))
    for limb, root, reach in (("arm", SHOULDER, ARM), ("leg", HIP, LEG)):
        for side, sign in SIDES:
            name = f"{limb}_{side}"
            swing, spread, twist, bend = (
                angle(f"{name}_{motion}", speed=10.0)  # [rad/s] of a joint
                for motion in ("swing", "spread", "twist", "bend")
            )
            upper = torso @ move(*_mirrored(root, sign)) @ rot_y(swing) @ rot_x(spread)
            upper = upper @ rot_z(twist)
            lower = upper @ move(0, 0, -reach) @ rot_y(bend)
            bodies += _links(name, upper, lower)
            joints += [
                Viscous(rate(q), parameter("c", 0.1, "N m s/rad"))
                for q in (swing, spread, twist, bend)
            ]
            place = lower @ move(0, 0, -ARM) if limb == "arm" else upper @ move(0, 0, -LEG)
            hooks[f"hand_{side}" if limb == "arm" else f"knee_{side}"] = place
    return PuppetBody((x, y, z), tuple(bodies), tuple(joints), hooks)


def _mirrored(place: Triple, sign: int) -> Triple:
    return place[0], sign * place[1], place[2]


def _trunk(torso: Frame) -> list[Body]:
    """Return torso and head with a face; all but the two weigh nothing."""
    head, moment = torso @ move(0, 0, NECK), parameter("J", 1.0, "kg m^2")
    m_t, m_h = parameter("m_torso", 50.0, "kg"), parameter("m_head", 10.0, "kg")
    jacket = (
        Capsule(0.35, 1.6, axis="y", at=(0, 0, 1.15)),
        Cylinder(0.65, 1.9, at=(0, 0, 0.2)),
        Capsule(0.42, 0.8, axis="y", at=(0, 0, -1.25)),
    )
    eyes = tuple(Sphere(0.13, at=(0.52, sign * 0.24, 0.14)) for _, sign in SIDES)
    pupils = tuple(Sphere(0.065, at=(0.61, sign * 0.24, 0.14)) for _, sign in SIDES)
    mouth = (Sphere(0.13, at=(0.66, 0, -0.06)), Box(0.1, 0.42, 0.09, at=(0.53, 0, -0.32)))
    hat = (Cylinder(0.78, 0.08, at=(0, 0, 0.4)), Cylinder(0.52, 0.7, at=(0, 0, 0.75)))
    buttons = tuple(Sphere(0.09, at=(0.65, 0, height)) for height in (0.9, 0.4, -0.1))
    return [
        Body("torso", torso, mass=m_t, inertia=moment, shape=jacket, color=RED),
        Body("head", head, mass=m_h, inertia=moment, shape=Sphere(0.62), color=SKIN),
        Body("eyes", head, shape=eyes, color=WHITE),
        Body("pupils", head, shape=pupils, color=DARK),
        Body("nose and mouth", head, shape=mouth, color=RED),
        Body("hat", head, shape=hat, color=DARK),
        Body("buttons", torso, shape=buttons, color=GOLD),
    ]


def _links(name: str, upper: Frame, lower: Frame) -> list[Body]:
    """Return both links of a limb, and the hand or shoe at its end, which weighs nothing."""
    m_u, m_l = parameter("m_upper", 5.0, "kg"), parameter("m_lower", 4.0, "kg")
    moment = parameter("J", 1.0, "kg m^2")
    arm = name.startswith("arm")
    reach, color = (ARM, RED) if arm else (LEG, BLUE)
    rod = Capsule(0.22, 1.2) if arm else Capsule(0.3, 1.55)
    links = [
        Body(
            f"{part} {name}",
            joint @ move(0, 0, -reach / 2),
            mass=mass,
            inertia=moment,
            shape=rod,
            color=color,
        )
        for part, joint, mass in (("upper", upper, m_u), ("lower", lower, m_l))
    ]
    if arm:
        return [
            *links,
            Body(f"hand_{name[-1]}", lower, shape=Sphere(0.3, (0, 0, -ARM)), color=SKIN),
        ]
    shoe = Box(1.0, 0.5, 0.35, at=(0.2, 0, -LEG))
    return [*links, Body(f"shoe_{name[-1]}", lower, shape=shoe, color=BROWN)]
