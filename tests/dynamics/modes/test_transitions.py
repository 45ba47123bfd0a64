"""Machines with modes against closed forms and walkers derived by hand."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.dynamics import Model
from kinolab.errors import KinolabError, SingularError
from kinolab.simulation.reference import follow
from tests.oracles.hopper import Ball, Hopper, WalledPendulum, impact
from tests.oracles.simplest_walker import Compass, compass_gait
from tests.switching_machines import ball, compass_walker, hopper, walled_pendulum

SECONDS = 1e-9  # to which a transition is located


def reference(model: Model, x: np.ndarray, t: np.ndarray) -> np.ndarray:
    u = np.zeros((len(t) - 1, model.nu))
    return follow(model, x, t, u, np.ones(model.nx)).x


def test_a_ball_bounces_as_in_closed_form() -> None:
    model, oracle = ball().model(), Ball(1.0, 0.0, 0.7, 9.81)
    t = np.linspace(0.0, 2.5, 51)  # nine bounces
    expected = np.array([oracle.state(time) for time in t])
    steps = model.steps([1.0, 0.0, 0.0], np.zeros((50, 0)), np.diff(t))
    assert np.abs(steps[:, :2] - expected).max() < 1e-11
    assert np.abs(reference(model, steps[0], t)[:, :2] - expected).max() < 1e-11


def test_bounces_without_end_are_an_error_that_names_them() -> None:
    model, rest = ball().model(), Ball(1.0, 0.0, 0.7, 9.81).rest_time
    with pytest.raises(SingularError, match=r"without end \(bounce\)"):
        model.step([1.0, 0.0, 0.0], [], 3.0)
    with pytest.raises(KinolabError, match=rf"beyond t = {rest:.6g}.*without end"):
        reference(model, np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 3.0]))


def test_a_pendulum_hits_its_wall_when_elliptic_integrals_say() -> None:
    model, oracle = walled_pendulum().model(), WalledPendulum()
    times, speeds = oracle.hits(3)
    for time, speed in zip(times, speeds, strict=True):
        before, after = time - 2 * SECONDS, time + 2 * SECONDS
        x = reference(model, np.array([1.5, 0.0, 0.0]), np.array([0.0, before, after]))
        assert x[1, 1] == pytest.approx(-speed, abs=1e-6)
        assert x[2, 1] == pytest.approx(0.7 * speed, abs=1e-6)


def test_a_hopper_hops_as_in_closed_form() -> None:
    """Landing is a plastic blow; the foot leaves when the ground would have to pull."""
    model, oracle = hopper().model(), Hopper()
    x, mode, t = np.array([1.0, 0.0, 0.0, 0.0]), 1.0, 0.0
    for _ in range(6):
        last = oracle.lift_off(x) if mode == 0.0 else oracle.touch_down(x)
        move = oracle.stance if mode == 0.0 else oracle.flight
        span = np.linspace(0.0, last - SECONDS, 1001)
        start = np.array([*x, mode])
        steps = model.steps(start, np.zeros((1000, 0)), np.diff(span))
        assert np.abs(steps[-1, :4] - move(x, span[-1])).max() < 1e-7  # of Runge-Kutta
        assert (steps[:, 4] == mode).all()
        found = reference(model, start, np.array([0.0, last - SECONDS, last + SECONDS]))
        x = move(x, last)
        assert np.abs(found[1, :4] - move(start[:4], last - SECONDS)).max() < 1e-8
        assert (found[1, 4], found[2, 4]) == (mode, 1.0 - mode)
        x = x if mode == 0.0 else oracle.landing(x)
        assert np.abs(found[2, :4] - x).max() < 1e-6  # after twice 1e-9 s at 10 m/s
        mode, t = 1.0 - mode, t + last


def test_a_compass_walks_the_gait_that_conserved_momenta_give() -> None:
    walker = Compass()
    section, period = compass_gait(walker, np.array([0.27, -1.09, -0.376]))
    model = compass_walker().model()
    theta, theta_dot, psi_dot = section
    gamma = walker.gamma
    stance, swing = theta - gamma, -theta - gamma  # from the vertical
    hip = np.array([-np.sin(stance), np.cos(stance)])
    hip_rate = -theta_dot * np.array([np.cos(stance), np.sin(stance)])
    start = np.array([*hip, stance, swing, *hip_rate, theta_dot, psi_dot, 0.0])
    assert np.abs(model.constraint_residual(start)[:2]).max() < 1e-12
    x = reference(model, start, np.array([0.0, period - SECONDS, period + SECONDS]))
    assert (x[1, -1], x[2, -1]) == (0.0, 1.0)
    right, left = x[2, [3, 7]], x[2, [2, 6]]
    assert np.abs(right - [stance, theta_dot]).max() < 1e-7
    assert np.abs(left - [swing, psi_dot]).max() < 1e-7
    assert sum(model.energy(x[2])) < sum(model.energy(x[1]))


def test_a_blow_is_that_of_any_machine() -> None:
    """M (v+ - v-) = J^T impulse with J v+ = 0, solved with NumPy from the mass matrix."""
    model = compass_walker().model()
    x = np.array([0.3, 0.9, -0.2, 0.4, 1.0, -0.5, -0.7, 0.3, 0.0])
    legs = x[2:4]
    c, s = np.cos(legs), np.sin(legs)
    J = np.array([[1, 0, 0, c[1]], [0, 1, 0, s[1]]])  # of the right foot
    height = x[0] * np.sin(0.0525) + x[1] * np.cos(0.0525)
    reach = np.sin(0.0525) * s[1] - np.cos(0.0525) * c[1]
    x[1] -= (height + reach) / np.cos(0.0525) + 1e-9
    x[5] -= 2.0  # down
    assert model.transition(x) == "right heel strikes"
    after = model.reset(x)
    expected, _ = impact(model.mass_matrix(x), x[4:8], J)
    assert np.abs(after[4:8] - expected).max() < 1e-9
    assert (after[:4] == x[:4]).all()
    assert after[8] == 1.0
