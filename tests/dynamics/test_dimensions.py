"""Units of velocities that are imposed, from what their symbols are."""

from __future__ import annotations

import pytest

from kinolab import systems
from kinolab.dynamics import Rate, angle, length, move, parameter, rate, rot_z, velocity
from kinolab.dynamics.symbols.dimensions import rate_unit_of

x, y, psi, delta = length("x"), length("y"), angle("psi"), angle("delta")
L, gear = parameter("L", 1.4, "m"), parameter("gear", 2.0)
V = velocity(move(x, y) @ rot_z(psi))


@pytest.mark.parametrize(
    ("on", "unit"),
    [
        (V.x, "m/s"),
        (V.wz, "rad/s"),
        (delta, "rad/s"),
        (x, "m/s"),
        (L * rate(psi), "m/s"),
        (rate(psi) - rate(delta), "rad/s"),
        (velocity(move(x, y) @ rot_z(psi) @ move(-1.4)).y, "m/s"),
        (gear * rate(psi), "m/s or rad/s"),  # a bare number may be a radius
    ],
)
def test_an_imposed_velocity_has_the_unit_of_its_expression(on: object, unit: str) -> None:
    assert Rate("drive", on=on, limit=1.0).unit == unit


def test_a_unicycle_goes_in_metres_and_turns_in_radians() -> None:
    units = {entry.name: entry.unit for entry in systems.get("unicycle1_v1").inputs}
    assert units["v"] == "m/s"
    assert rate_unit_of(rate(psi)) == "rad/s"
