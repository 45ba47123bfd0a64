"""A puppet on six strings below a control bar."""

from __future__ import annotations

from sympy import Expr, pi, sin

from kinolab.dynamics import (
    Body,
    Box,
    Cable,
    Coordinate,
    Disk,
    Drive,
    Feedback,
    Frame,
    Reference,
    Rope,
    System,
    length,
    move,
    parameter,
    rate,
    rot_y,
    toward,
)
from kinolab.systems._puppet import BROWN, GOLD, SIDES, puppet_body

SPINDLES = {"shoulder": (0.0, 1.0), "hand": (2.0, 1.6), "knee": (5.0, 0.8)}  # [m] left, on the bar
LENGTHS = {"shoulder": (13.4, 13.4), "hand": (15.4, 15.5), "knee": (18.6, 18.6)}  # [m] left, right
LIFTS = {"hand": (-1.0, 5.0), "knee": (-0.6, 2.0)}  # [m] by which strings may be reeled in
STRIDE, LIFT = 1.6, 0.4  # [m] of a step: along the stage, and by which its knee is lifted
HAND, BEND = (0.0, 3.0), (0.0, 1.0)  # [m] by which strings of hands and knees are reeled in
REEL = 0.25  # [m] radius
CROSS = (  # of wood, that the puppeteer holds
    Box(6.0, 0.3, 0.2, at=(2.5, 0, 0.1)),
    *(Box(0.3, 2 * aside + 0.3, 0.2, at=(ahead, 0, 0.1)) for ahead, aside in SPINDLES.values()),
)


def marionette() -> System:
    """A puppet that hangs from a control bar by strings at its shoulders, hands and knees.

    The puppet has 22 coordinates: its torso is free in space, a joint of three angles joins every
    limb to it, and one more bends each limb. Strings only pull, and go slack and taut by
    themselves. What the puppeteer does is driven: the bar's place, and by how much the strings of
    hands and knees are reeled in. Its controller is the puppeteer's skill: the bar goes at the
    speed that is asked for and yields to the torso, whose swing would not die out in minutes else;
    the knees are lifted in turn as the bar goes along, one up and the other one down as by the
    rocking bar of a real control, and both as far as they shall bend; hands as far as one asks.

    Source: Johnson, Murphey, Dynamic modeling and motion planning for marionettes: rigid bodies
    articulated by massless strings, ICRA 2007. The strings there do not stretch; these give by
    their tension over k, less than 2 per mille of their length under the whole weight.
    """
    puppet = puppet_body()
    bar_x, bar_y = length("bar_x", speed=1.5), length("bar_y", speed=1.5)
    bar = move(bar_x, bar_y, parameter("H", 14.0, "m"))
    lifts = {
        f"{part}_{side}": length(f"lift_{part}_{side}", *LIFTS[part], speed=1.0)  # [m/s] at most
        for part in LIFTS
        for side, _ in SIDES
    }
    spindles = {
        f"{part}_{side}": bar @ move(ahead, sign * aside)
        for part, (ahead, aside) in SPINDLES.items()
        for side, sign in SIDES
    }
    pushes = Drive("push_x", on=bar_x, limit=1.0), Drive("push_y", on=bar_y, limit=1.0)
    reels = {name: Drive(f"reel_{name}", on=lift, limit=2.0) for name, lift in lifts.items()}
    return System(
        "marionette",
        bodies=[
            *puppet.bodies,
            Body("control bar", bar, mass=5.0, shape=CROSS, color=BROWN),
            *(_reel(name, spindles[name], lift) for name, lift in lifts.items()),
        ],
        gravity=toward("-z", parameter("g", 9.81, "m/s^2")),
        inputs=[*pushes, *reels.values()],
        efforts=[*puppet.joints, *_strings(spindles, puppet.hooks, lifts)],
        cables=[
            Cable((spindle, puppet.hooks[name]), f"string {name}", radius=0.02)
            for name, spindle in spindles.items()
        ],
        feedback=_puppeteer(pushes, reels, puppet.place),
    )


def _puppeteer(
    pushes: tuple[Drive, Drive],
    reels: dict[str, Drive],
    torso: tuple[Coordinate, Coordinate, Coordinate],
) -> Feedback:
    """Return the law that carries the bar, rocks the knees and lifts the hands."""
    speeds = Reference("go_x", limit=0.8, unit="m/s"), Reference("go_y", limit=0.8, unit="m/s")
    hands = {f"hand_{side}": Reference(f"raise_{side}", limit=HAND, unit="m") for side, _ in SIDES}
    bend = Reference("bend", limit=BEND, unit="m")
    rocking = LIFT * sin(pi * pushes[0].on / STRIDE)
    aims = {name: hand.symbol for name, hand in hands.items()}
    aims |= {f"knee_{side}": bend.symbol + sign * rocking for side, sign in SIDES}
    # 0.388 [m] by which the strings of hands and knees draw the torso ahead of the bar
    law: dict[str, Expr] = {
        push.name: _carry(push.on, place, speed.symbol, lead)
        for push, place, speed, lead in zip(pushes, torso[:2], speeds, (0.388, 0.0), strict=True)
    }
    law |= {reels[name].name: _servo(reels[name].on, aim, name) for name, aim in aims.items()}
    return Feedback([*speeds, *hands.values(), bend], law)


def _carry(bar: Coordinate, torso: Coordinate, speed: Expr, lead: float) -> Expr:
    """Return the bar's acceleration along one axis.

    With the torso's swing s about where it hangs, s_ddot = -w^2 s - bar_ddot and w near 0.85 /s,
    the characteristic polynomial is r^3 + (a + c) r^2 + (w^2 + b) r + a w^2: its roots are
    -1.06 and -0.32 +- 0.49 i.
    """
    a, b, c = 0.5, 0.3, 1.2  # [1/s], [1/s^2], [1/s]
    swinging = rate(torso) - rate(bar)
    return a * (speed - rate(bar)) + b * (torso - bar - lead) + c * swinging


def _servo(lift: Coordinate, aim: Expr, name: str) -> Expr:
    """Return the acceleration by which a string is reeled in; hands go gently, knees keep up."""
    pace = 0.8 if name.startswith("hand") else 2.5  # [1/s]
    return pace**2 * (aim - lift) - 2 * pace * rate(lift)


def _strings(
    spindles: dict[str, Frame], hooks: dict[str, Frame], lifts: dict[str, Coordinate]
) -> list[Rope]:
    """Return the six strings; ``lifts`` are coordinates by which some are shorter."""
    k, d = parameter("k", 2e4, "N/m"), parameter("d", 200.0, "N s/m")
    lengths = {
        f"{part}_{side}": parameter(f"L_{part}_{side}", value, "m")
        for part, both in LENGTHS.items()
        for (side, _), value in zip(SIDES, both, strict=True)
    }
    return [
        Rope(
            between=(spindle, hooks[name]),
            stiffness=k,
            length=lengths[name] - lifts.get(name, 0),
            damping=d,
        )
        for name, spindle in spindles.items()
    ]


def _reel(name: str, spindle: Frame, lift: Coordinate) -> Body:
    """Return the reel that a string is wound on."""
    m, across = 1.0, REEL**2 / 3  # [kg], [m^2]: as wide as its radius
    return Body(
        f"reel {name}",
        spindle @ move(0, 0, REEL) @ rot_y(lift / REEL),
        mass=m,
        inertia=(m * across, m * REEL**2 / 2, m * across),
        shape=Disk(REEL, REEL, axis="y"),
        color=GOLD,
    )
