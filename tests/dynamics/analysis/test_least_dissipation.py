"""Least dissipation of bodies on feet, where it is known without a search."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.dynamics import (
    Body,
    Coulomb,
    SlidingFriction,
    System,
    Viscous,
    angle,
    least_dissipation,
    length,
    move,
    parameter,
    rate,
    rot_z,
    velocity,
    zero,
)
from kinolab.errors import InputError, UnknownNameError

X, Y, PSI = length("x"), length("y"), angle("psi")
BOX = Body("box", move(X, Y) @ rot_z(PSI), mass=1.0, inertia=0.1)
V = velocity(BOX.frame)
FIRM, LOOSE = 8.0, 3.0  # [N] grips of the feet
REACH = 0.2  # [m] of the feet, ahead and behind


def feet(firm: float = FIRM) -> list[SlidingFriction]:
    """One foot ahead and one behind; where either stands, both slips are those of its point."""
    return [
        SlidingFriction((V.x, V.y + along * V.wz), strength)
        for along, strength in ((REACH, firm), (-REACH, LOOSE))
    ]


def box(*efforts: SlidingFriction | Coulomb | Viscous) -> System:
    return System("box", bodies=[BOX], efforts=efforts)


@pytest.mark.parametrize("psi", [0.0, 0.9, -2.5])
def test_a_turned_box_turns_about_its_firmer_foot(psi: float) -> None:
    """Sum of two distances to two points, weighted: least at the heavier one (Weber, Fermat)."""
    turn = 2.0
    found = least_dissipation(box(*feet()), {rate(PSI): turn}, {PSI: psi})
    ahead = np.array([found.rates["x_dot"], found.rates["y_dot"]])
    stays = ahead + REACH * turn * np.array([-np.sin(psi), np.cos(psi)])
    assert stays == pytest.approx(np.zeros(2), abs=1e-7)
    assert found.power == pytest.approx(LOOSE * 2 * REACH * turn, rel=1e-6)
    assert found.bound == pytest.approx(found.power, rel=1e-6)
    assert found.bound <= found.power + 1e-12


def test_it_is_the_same_at_any_speed_and_grip() -> None:
    """Coulomb friction knows no time: rates scale with those given, power with both."""
    slow = least_dissipation(box(*feet()), {"psi_dot": 1e-3})
    fast = least_dissipation(box(*feet()), {"psi_dot": 1.0})
    for name, value in fast.rates.items():
        assert slow.rates[name] == pytest.approx(1e-3 * value, abs=1e-10)
    assert slow.power == pytest.approx(1e-3 * fast.power, rel=1e-6)


def test_what_nothing_drives_rests() -> None:
    found = least_dissipation(box(*feet()), {})
    assert set(found.rates.values()) == {0.0}
    assert found.power == found.bound == 0.0


def test_constraints_hold() -> None:
    """A skate under the middle: it cannot turn about a foot, so both slide."""
    skate = box(*feet()).changed(constraints=[zero(V.y, "no sideslip")])
    found = least_dissipation(skate, {"psi_dot": 2.0})
    assert [found.rates["x_dot"], found.rates["y_dot"]] == pytest.approx([0, 0], abs=1e-7)
    assert found.power == pytest.approx((FIRM + LOOSE) * REACH * 2.0, rel=1e-6)


def test_friction_along_a_line_holds_in_it_alone() -> None:
    """One foot on rails, with more grip along them than the other has: it does not slide along."""
    along, across = Coulomb(V.x, FIRM), SlidingFriction((V.x, V.y + REACH * V.wz), LOOSE)
    found = least_dissipation(box(along, across), {"psi_dot": 1.0})
    assert found.rates["x_dot"] == pytest.approx(0, abs=1e-7)
    assert found.rates["y_dot"] == pytest.approx(-REACH, abs=1e-7)
    assert found.power < 1e-6


@pytest.mark.parametrize(
    ("machine", "given", "said"),
    [
        (box(Viscous(V.x, 1.0)), {"psi_dot": 1.0}, "it has no dry friction"),
        (box(*feet(0.0)[:1]), {"psi_dot": 1.0}, "it has no dry friction"),
        (box(*feet(X - 1.0)), {"psi_dot": 1.0}, "the strength of a friction is -1"),
        (box(Coulomb(V.x, V.x**2)), {"psi_dot": 1.0}, "It must be a number"),
        (
            box(*feet()).changed(constraints=[zero(rate(X), "held")]),
            {"x_dot": 1.0},
            "its constraints forbid the given rates",
        ),
    ],
)
def test_what_has_no_answer_is_refused(machine: System, given: dict[str, float], said: str) -> None:
    with pytest.raises(InputError, match=said):
        least_dissipation(machine, given)


def test_an_unknown_rate_is_told_with_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match=r"Did you mean 'psi_dot'\?"):
        least_dissipation(box(*feet()), {"psy_dot": 1.0})


def test_parameters_have_their_values() -> None:
    grip = parameter("grip", 5.0, "N")
    machine = box(SlidingFriction((V.x, V.y), grip))
    for value in (5.0, 7.0):
        found = least_dissipation(machine.with_parameters(grip=value), {"x_dot": 2.0})
        assert found.power == pytest.approx(2.0 * value, rel=1e-9)
