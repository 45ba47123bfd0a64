"""A hand derivation is right, or the term that is wrong is named."""

from __future__ import annotations

import sympy

from kinolab import systems
from kinolab.dynamics import (
    Body,
    Force,
    System,
    acceleration,
    angle,
    force_of,
    length,
    move,
    parameter,
    rate,
    rot_y,
    rot_z,
    velocity,
    zero,
)
from kinolab.dynamics.symbols.symbols import InputSymbol

PENDULUM = systems.get("pendulum")
THETA = PENDULUM.coordinates[0]
G, L, M = PENDULUM.parameters
TORQUE = InputSymbol("torque")

DISK = systems.get("rolling_disk")
X, Y, PSI, PHI = DISK.coordinates
R, _, MASS, _ = DISK.parameters
DRIVE, STEER = InputSymbol("drive"), InputSymbol("steer")


def test_the_right_equation_agrees_up_to_a_factor() -> None:
    hand = sympy.Eq(acceleration(THETA) + G / L * sympy.sin(THETA), TORQUE / (M * L**2))
    verdict = PENDULUM.agrees_with([hand])
    assert verdict
    assert str(verdict) == "equation 1: agrees."


def test_a_wrong_sign_of_gravity_is_named() -> None:
    hand = M * L**2 * acceleration(THETA) - M * G * L * sympy.sin(THETA) - TORQUE
    verdict = PENDULUM.agrees_with([hand])
    assert not verdict
    wrong, right = "-m g l sin(\u03b8)", "m g l sin(\u03b8)"
    assert str(verdict) == f"equation 1: has {wrong} where it should be {right}."


def test_a_forgotten_torque_and_an_invented_term_are_named() -> None:
    hand = M * L**2 * acceleration(THETA) + M * G * L * sympy.sin(THETA) + M * rate(THETA) ** 2
    verdict = PENDULUM.agrees_with([hand])
    assert not verdict
    assert str(verdict) == "equation 1: has m \u03b8\u0307\u00b2 too much and lacks -torque."


def test_a_term_that_a_puck_in_polar_coordinates_lacks_is_named_with_its_sign() -> None:
    """By hand: m r'' - m r theta'^2 = pull, as 1/m of it, doubled, and with its sides swapped."""
    m, r, theta = parameter("m", 2.0, "kg"), length("r"), angle("theta")
    spoke = rot_z(theta) @ move(r, 0, 0)
    puck = Body("puck", spoke, mass=m)
    polar = System(
        "polar", bodies=[puck], inputs=[Force("pull", on=puck, along=spoke.x, limit=1.0)]
    )
    pull, spin = InputSymbol("pull"), rate(theta) ** 2
    right = sympy.Eq(m * acceleration(r), m * r * spin + pull)
    assert polar.agrees_with([right]).agreed == (True,)
    for hand, words in (
        (m * acceleration(r) - pull, "lacks -m r \u03b8\u0307\u00b2"),
        (
            m * acceleration(r) - 2 * m * r * spin - pull,
            "has -2 m r \u03b8\u0307\u00b2 where it should be -m r \u03b8\u0307\u00b2",
        ),
        (acceleration(r) - r * spin, "lacks -pull/m"),
        (2 * m * acceleration(r) - 2 * pull, "lacks -2 m r \u03b8\u0307\u00b2"),
        (pull - m * acceleration(r), "lacks m r \u03b8\u0307\u00b2"),
        (
            sympy.Eq(m * acceleration(r), pull - m * r * spin),
            "with all terms on the left it has m r \u03b8\u0307\u00b2 where it should be "
            "-m r \u03b8\u0307\u00b2",
        ),
    ):
        assert str(polar.agrees_with([hand])) == f"equation 1: {words}."


def test_an_identity_that_nobody_simplified_is_no_difference() -> None:
    s, c = sympy.sin(THETA / 2), sympy.cos(THETA / 2)
    assert PENDULUM.agrees_with([M * L**2 * acceleration(THETA) + 2 * M * G * L * s * c - TORQUE])


def test_reduced_and_multiplier_forms_of_the_disk_both_count_in_any_order() -> None:
    reduced = [
        sympy.Eq(3 * MASS * R**2 * acceleration(PHI), 2 * DRIVE),
        sympy.Eq(MASS * R**2 * acceleration(PSI), 4 * STEER),
    ]
    assert DISK.agrees_with(reduced)
    one, two = sympy.symbols("lambda_1 lambda_2", real=True)
    c, s = sympy.cos(PSI), sympy.sin(PSI)
    full = [
        sympy.Eq(MASS * R**2 / 4 * acceleration(PSI), STEER),
        sympy.Eq(MASS * R**2 / 2 * acceleration(PHI), DRIVE - R * two),
        sympy.Eq(MASS * acceleration(X), two * c - one * s),
        sympy.Eq(MASS * acceleration(Y), one * c + two * s),
    ]
    assert DISK.agrees_with(full)


def test_the_classical_mistake_of_forgetting_the_rolling_mass_is_named() -> None:
    """m R^2 of the translation is missing, so everything else is off by the factor 3."""
    hand = [
        sympy.Eq(MASS * R**2 * acceleration(PHI) / 2, DRIVE),
        sympy.Eq(MASS * R**2 * acceleration(PSI) / 4, STEER),
    ]
    verdict = DISK.agrees_with(hand)
    assert verdict.agreed == (False, True)


def test_an_equation_that_is_left_out_is_missed() -> None:
    verdict = DISK.agrees_with([sympy.Eq(3 * MASS * R**2 * acceleration(PHI), 2 * DRIVE)])
    assert not verdict
    assert len(verdict.missing) == 1
    assert "steer" in verdict.missing[0]


def test_multipliers_are_told_by_name_or_as_forces_of_their_constraints() -> None:
    m, R = parameter("m", 1.0, "kg"), parameter("R", 0.25, "m")
    x, y, psi, phi = length("x"), length("y"), angle("psi"), angle("phi")
    fork = move(x, y, R) @ rot_z(psi)
    inertia = (m * R**2 / 4, m * R**2 / 2, m * R**2 / 4)
    coin = Body("coin", fork @ rot_y(phi), mass=m, inertia=inertia)
    V = velocity(fork)
    side, roll = zero(V.y, "m"), zero(V.x - R * rate(phi), "rolling")  # named like the mass
    disk = System("disk", bodies=[coin], constraints=[side, roll])
    for a, b in (
        sympy.symbols("lambda_1 lambda_2"),
        sympy.symbols("lambda_1 lambda_2", real=True),
        (force_of(side), force_of(roll)),
    ):
        assert disk.agrees_with(
            [
                m * acceleration(x) + a * sympy.sin(psi) - b * sympy.cos(psi),
                m * acceleration(y) - a * sympy.cos(psi) - b * sympy.sin(psi),
                m * R**2 / 4 * acceleration(psi),
                m * R**2 / 2 * acceleration(phi) + R * b,
            ]
        )
        assert not disk.agrees_with([m * R**2 / 2 * acceleration(phi) - R * b])
