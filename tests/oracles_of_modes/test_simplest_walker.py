"""The walkers' oracle against published gaits, quadrature and a second derivation."""

from __future__ import annotations

import numpy as np
import pytest

from tests.oracles.simplest_walker import (
    LONG_GAIT,
    SHORT_GAIT,
    Array,
    Compass,
    FellError,
    compass_coriolis,
    compass_energy,
    compass_gait,
    compass_kinetic_energy,
    compass_mass_matrix,
    compass_points,
    compass_rate,
    compass_strike,
    compass_strike_by_impulse,
    compass_swing,
    light_footed,
    simplest_gait,
    simplest_multipliers,
    simplest_period,
    simplest_rate,
    simplest_speed,
    simplest_start,
    simplest_strike,
    simplest_swing,
)

GAMMA = 0.009
PERIOD = 3.8824636  # [sqrt(l / g)], published for the long gait
ODD = Compass(m_h=7.0, m=3.0, l=1.2, b=0.7, gamma=0.06)


def cross(r: Array, p: Array) -> float:
    return float(r[0] * p[1] - r[1] * p[0])


def random_state(seed: int) -> Array:
    return np.random.default_rng(seed).uniform(-1, 1, 4)


def test_long_gait_is_the_published_one() -> None:
    section, period = simplest_gait(GAMMA, LONG_GAIT)
    assert section == pytest.approx(LONG_GAIT, abs=5e-8)  # what was published
    assert period == pytest.approx(PERIOD, abs=5e-7)  # what the angle's last digit moves


def test_only_the_long_gait_is_stable() -> None:
    short, _ = simplest_gait(GAMMA, SHORT_GAIT)
    assert short == pytest.approx(SHORT_GAIT, abs=5e-7)
    assert np.abs(simplest_multipliers(LONG_GAIT, GAMMA)).max() == pytest.approx(0.5891, abs=1e-4)
    assert np.abs(simplest_multipliers(short, GAMMA)).max() > 3


@pytest.mark.parametrize("guess", [LONG_GAIT, SHORT_GAIT])
def test_gait_falls_by_what_the_heelstrike_takes(guess: Array) -> None:
    section, period = simplest_gait(GAMMA, guess)
    assert section[1] == pytest.approx(simplest_speed(section[0], GAMMA), abs=1e-10)
    assert period == pytest.approx(simplest_period(section[0], section[1], GAMMA), abs=1e-10)


def test_stance_leg_keeps_its_energy() -> None:
    x = simplest_swing(simplest_start(*LONG_GAIT), GAMMA).x
    energy = x[:, 2] ** 2 / 2 + np.cos(x[:, 0] - GAMMA)
    assert np.ptp(energy) < 1e-12


def test_walker_that_stands_too_still_falls() -> None:
    with pytest.raises(FellError, match="no heelstrike"):
        simplest_swing(simplest_start(0.2, -0.1), GAMMA)


@pytest.mark.parametrize("seed", range(3))
def test_kinetic_energy_is_that_of_the_mass_matrix(seed: int) -> None:
    x = random_state(seed)
    M = compass_mass_matrix(x[0], x[1], ODD)
    assert x[2:] @ M @ x[2:] / 2 == pytest.approx(compass_kinetic_energy(x, ODD), rel=1e-13)


@pytest.mark.parametrize("seed", range(3))
def test_coriolis_is_skew_against_the_mass_matrix(seed: int) -> None:
    x, h = random_state(seed), 1e-6
    shifted = [x[:2] + s * h * x[2:] for s in (1, -1)]
    ahead, behind = (compass_mass_matrix(q[0], q[1], ODD) for q in shifted)
    skew = (ahead - behind) / (2 * h) - 2 * compass_coriolis(x, ODD)
    assert skew + skew.T == pytest.approx(np.zeros((2, 2)), abs=1e-8)


@pytest.mark.parametrize("seed", range(3))
def test_swing_balances_moments_about_foot_and_hip(seed: int) -> None:
    """D'Alembert: m (acceleration - gravity) has no moment about a joint without a motor."""
    x, h = random_state(seed), 1e-4
    acceleration = compass_rate(x, ODD)[2:]
    at = [x[:2] + s * x[2:] + s**2 * acceleration / 2 for s in (-h, 0.0, h)]
    before, now, after = (compass_points(q[0], q[1], ODD) for q in at)
    accelerations = (before - 2 * now + after) / h**2
    gravity = ODD.g * np.array([np.sin(ODD.gamma), -np.cos(ODD.gamma)])
    forces = np.array([[ODD.m_h], [ODD.m], [ODD.m]]) * (accelerations[:3] - gravity)
    whole = sum(cross(r, f) for r, f in zip(now[:3], forces, strict=True))
    assert whole == pytest.approx(0, abs=1e-5)  # [N m]; the differences' error is h^2
    assert cross(now[2] - now[0], forces[2]) == pytest.approx(0, abs=1e-5)


@pytest.mark.parametrize("seed", range(4))
def test_strike_agrees_with_an_impulse_on_four_coordinates(seed: int) -> None:
    x = random_state(seed)
    x[1] = -x[0]
    assert compass_strike(x, ODD) == pytest.approx(compass_strike_by_impulse(x, ODD), abs=1e-12)


@pytest.mark.parametrize("seed", range(8))
def test_strike_takes_kinetic_energy(seed: int) -> None:
    x = random_state(seed)
    x[1] = -x[0]
    after = compass_kinetic_energy(compass_strike(x, ODD), ODD)
    assert after < compass_kinetic_energy(x, ODD)


def test_compass_walks_as_published() -> None:
    """Goswami et al. on 3 degrees with g = 9.8; they measure from the vertical."""
    walker = Compass(g=9.8, gamma=np.pi / 60)
    (theta, theta_dot, psi_dot), period = compass_gait(walker, np.array([0.27, -1.09, -0.38]))
    found = [theta - walker.gamma, -theta - walker.gamma, theta_dot, psi_dot]
    assert found == pytest.approx([0.2187, -0.3234, -1.0918, -0.3772], abs=5e-5)
    assert period == pytest.approx(0.7347, abs=5e-5)


def test_compass_gait_falls_by_what_the_heelstrike_takes() -> None:
    walker = Compass()
    section, _ = compass_gait(walker, np.array([0.27, -1.09, -0.38]))
    start = np.array([section[0], -section[0], section[1], section[2]])
    swing = compass_swing(start, walker)
    energies = np.array([compass_energy(x, walker) for x in swing.x])
    assert np.ptp(energies) < 1e-9  # [J] of 170
    lost = compass_kinetic_energy(swing.x[-1], walker) - compass_kinetic_energy(start, walker)
    step = 2 * walker.l * np.sin(section[0])
    assert lost == pytest.approx(walker.mass * walker.g * step * np.sin(walker.gamma), rel=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_light_feet_make_the_simplest_walker(seed: int) -> None:
    """Swings and strikes differ by O(m / m_h)."""
    x = random_state(seed)
    simple = np.array([x[0], x[0] - x[1], x[2], x[2] - x[3]])
    struck = np.array([x[0], -x[0], x[2], x[3]])
    swing_errors, strike_errors = [], []
    for beta in (1e-3, 1e-4):
        walker = light_footed(beta, GAMMA)
        rate, after = compass_rate(x, walker), compass_strike(struck, walker)
        phi_ddot = rate[2] - rate[3]
        expected = simplest_rate(simple, GAMMA)[2:]
        swing_errors.append(np.abs([rate[2], phi_ddot] - expected).max())
        phi_after = [after[0], after[0] - after[1], after[2], after[2] - after[3]]
        strike = simplest_strike(np.array([x[0], 2 * x[0], x[2], x[2] - x[3]]))
        strike_errors.append(np.abs(phi_after - strike).max())
    for errors in (swing_errors, strike_errors):
        assert errors[1] < errors[0] / 8  # first order promises 10
        assert errors[0] < 2e-2


def test_light_footed_gait_comes_near_the_simplest() -> None:
    section, period = simplest_gait(GAMMA, LONG_GAIT)
    start = simplest_start(*section)
    guess = np.array([start[0], start[2], start[2] - start[3]])
    errors = []
    for beta in (1e-3, 1e-4):
        found, takes = compass_gait(light_footed(beta, GAMMA), guess)
        errors.append(max(np.abs(found - guess).max(), abs(takes - period)))
    assert errors[1] < errors[0] / 8
    assert errors[1] < 1e-2
