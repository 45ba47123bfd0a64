"""Momenta of machines that float, and flat outputs, as mechanics has them."""

from __future__ import annotations

import pytest

from kinolab import systems
from kinolab.analyze.describe.conserved import momenta_of
from kinolab.analyze.describe.data import description_to_json
from kinolab.analyze.describe.description import describe
from kinolab.analyze.describe.description_text import described_as_text
from kinolab.dynamics import (
    Body,
    Force,
    Gravity,
    System,
    Torque,
    angle,
    length,
    move,
    orient,
    rot_y,
    rotation,
    toward,
)

TURNING = "its angular momentum about its centre of mass"
SLIDING = "its linear momentum"


def floating_arm(gravity: Gravity | None = None, *, thruster: bool = False) -> System:
    """Return a body that floats and swings an arm: each pushes the other alone, but a thruster."""
    x, y, z, turn, q = length("x"), length("y"), length("z"), rotation("base"), angle("q")
    hull = move(x, y, z) @ orient(turn)
    elbow = hull @ move(0.3, 0, 0) @ rot_y(q)
    base = Body("hull", hull, mass=4.0, inertia=(0.3, 0.5, 0.4))
    arm = Body("arm", elbow @ move(0, 0, 0.4), mass=1.0, inertia=(0.05, 0.04, 0.01))
    motors: list[Torque | Force] = [Torque("motor", on=arm, about=elbow.y, limit=1, reacts_on=base)]
    if thruster:
        motors.append(Force("thruster", on=base, along=hull.x, limit=1.0))
    return System("floating_arm", bodies=[base, arm], inputs=motors, gravity=gravity)


@pytest.mark.parametrize(
    ("machine", "kept"),
    [
        (floating_arm(), (SLIDING, TURNING)),
        (floating_arm(toward("-z")), (f"{SLIDING} along x and y", TURNING)),
        (floating_arm(toward("-x")), (f"{SLIDING} along y and z", TURNING)),
        (floating_arm(thruster=True), ()),
        (systems.get("satellite"), (TURNING,)),  # its wheels turn against it
        (systems.get("quad3d_v0"), ()),
    ],
    ids=lambda value: getattr(value, "name", None),
)
def test_a_floating_machine_keeps_what_nothing_outside_changes(
    machine: System, kept: tuple[str, ...]
) -> None:
    """Newton's third law; weight changes the momentum along it, and turns nothing by itself."""
    assert [one for one in momenta_of(machine) if one in kept] == list(kept)
    assert all(one in kept or one == SLIDING for one in momenta_of(machine))


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("rolling_disk", "flat: x and y, to their 3rd derivatives; this leaves phi free, on which"),
        ("crane", "flat if friction is neglected: X, Y and Z, to their 4th derivatives (given)"),
        ("pendulum", "flat: theta, to its 2nd derivative (found)"),
        ("acrobot_v0", "not flat: it has one input (tau)"),
    ],
)
def test_flatness_is_told(name: str, told: str) -> None:
    found = describe(systems.get(name))
    assert f"\n  {told}" in described_as_text(found)
    assert str(found.flat).startswith(told)
    assert description_to_json(found)["flatness"]["sentence"] == str(found.flat)
