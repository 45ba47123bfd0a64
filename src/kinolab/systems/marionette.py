"""A puppet on six strings below a control bar."""

from __future__ import annotations

from kinolab.dynamics import (
    Body,
    Box,
    Cable,
    Coordinate,
    Disk,
    Drive,
    Frame,
    Rope,
    System,
    length,
    move,
    parameter,
    rot_y,
    toward,
)
from kinolab.systems._puppet import BROWN, GOLD, SIDES, puppet_body

SPINDLES = {"shoulder": (0.0, 1.0), "hand": (2.0, 1.6), "knee": (5.0, 0.8)}  # [m] left, on the bar
LENGTHS = {"shoulder": (13.4, 13.4), "hand": (15.4, 15.5), "knee": (18.6, 18.6)}  # [m] left, right
LIFTS = {"hand": (-1.0, 5.0), "knee": (-0.6, 2.0)}  # [m] by which strings may be reeled in
REELING = 1.0  # [m/s] at most
REEL = 0.25  # [m] radius


def marionette() -> System:
    """A puppet that hangs from a control bar by strings at its shoulders, hands and knees.

    The puppet has 22 coordinates: its torso is free in space, a joint of three angles joins every
    limb to it, and one more bends each limb. Strings only pull, and go slack and taut by
    themselves. What the puppeteer does is driven: the bar's place, and by how much the strings of
    hands and knees are reeled in.

    Source: Johnson, Murphey, Dynamic modeling and motion planning for marionettes: rigid bodies
    articulated by massless strings, ICRA 2007. The strings there do not stretch; these give by
    their tension over k, less than 2 per mille of their length under the whole weight.
    """
    puppet = puppet_body()
    bar_x, bar_y = length("bar_x", speed=1.5), length("bar_y", speed=1.5)
    bar = move(bar_x, bar_y, parameter("H", 14.0, "m"))
    lifts = {
        f"{part}_{side}": length(f"lift_{part}_{side}", *LIFTS[part], speed=REELING)
        for part in LIFTS
        for side, _ in SIDES
    }
    spindles = {
        f"{part}_{side}": bar @ move(ahead, sign * aside)
        for part, (ahead, aside) in SPINDLES.items()
        for side, sign in SIDES
    }
    return System(
        "marionette",
        bodies=[
            *puppet.bodies,
            _control_bar(bar),
            *(_reel(name, spindles[name], lift) for name, lift in lifts.items()),
        ],
        gravity=toward("-z", parameter("g", 9.81, "m/s^2")),
        inputs=[
            Drive("push_x", on=bar_x, limit=1.0),
            Drive("push_y", on=bar_y, limit=1.0),
            *(Drive(f"reel_{name}", on=lift, limit=2.0) for name, lift in lifts.items()),
        ],
        efforts=[*puppet.joints, *_strings(spindles, puppet.hooks, lifts)],
        cables=[
            Cable((spindle, puppet.hooks[name]), f"string {name}", radius=0.02)
            for name, spindle in spindles.items()
        ],
    )


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


def _control_bar(bar: Frame) -> Body:
    """Return the cross of wood that the puppeteer holds."""
    beam = Box(6.0, 0.3, 0.2, at=(2.5, 0, 0.1))
    arms = tuple(
        Box(0.3, 2 * aside + 0.3, 0.2, at=(ahead, 0, 0.1)) for ahead, aside in SPINDLES.values()
    )
    return Body("control bar", bar, mass=5.0, shape=(beam, *arms), color=BROWN)


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
