"""Machines with modes against closed forms and walkers derived by hand."""

from __future__ import annotations

import numpy as np
import pytest
import sympy
from scipy.optimize import fsolve

from kinolab.dynamics import Body, Mode, Model, System, Transition, length, move, toward
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


def bouncing_between(z: float, speed: float, time: float) -> tuple[float, float]:
    """Height and speed of a ball that neither floor (0) nor ceiling (1 m) slows down."""
    g, left = 9.81, time
    while True:
        fall = (speed + np.sqrt(speed**2 + 2 * g * z)) / g
        square = speed**2 - 2 * g * (1.0 - z)
        rise = (speed - np.sqrt(square)) / g if square > 0 and speed > 0 else np.inf
        next_ = min(fall, rise)
        if next_ >= left:
            return z + speed * left - g * left**2 / 2, speed - g * left
        z, speed, left = float(rise < fall), g * next_ - speed, left - next_


@pytest.mark.parametrize("step", [0.85, 0.5, 0.2, 0.05])
@pytest.mark.parametrize("speed", [4.6, 6.0])
def test_a_step_finds_the_ceiling_that_a_ball_meets_and_falls_from(
    step: float, speed: float
) -> None:
    """Within one step it passes the ceiling and is below it again, or has hit the floor as well.

    With 4.6 m/s it would rise to 1.08 m, so that it is above the ceiling for 0.25 s.
    """
    z = length("z", -1.0, 2.0)
    floor = Transition("floor", "flight", "flight", until=z, restitution=1.0)
    ceiling = Transition("ceiling", "flight", "flight", until=1 - z, restitution=1.0)
    model = System(
        "ball",
        bodies=[Body("ball", move(0, 0, z), mass=1.0)],
        gravity=toward("-z", 9.81),
        modes=[Mode("flight")],
        transitions=[floor, ceiling],
    ).model()
    t = step * np.arange(5)
    expected = np.array([bouncing_between(0.0, speed, time) for time in t])
    x = np.array([0.0, speed, 0.0])
    steps = model.steps(x, np.zeros((4, 0)), np.diff(t))
    assert np.abs(steps[:, :2] - expected).max() < 1e-10  # [m], [m/s]; 4e-15 s in each of bounces
    assert np.abs(reference(model, x, t)[:, :2] - expected).max() < 1e-10


def test_a_ball_that_stays_below_the_ceiling_does_not_meet_it() -> None:
    """4.4 m/s carry it 0.987 m high: the tangents meet above the ceiling, the ball does not."""
    z = length("z", -1.0, 2.0)
    ceiling = Transition("ceiling", "flight", "flight", until=1 - z, restitution=1.0)
    model = System(
        "ball",
        bodies=[Body("ball", move(0, 0, z), mass=1.0)],
        gravity=toward("-z", 9.81),
        modes=[Mode("flight")],
        transitions=[ceiling],
    ).model()
    expected = [4.4 * 0.8 - 9.81 * 0.8**2 / 2, 4.4 - 9.81 * 0.8]
    x = np.array([0.0, 4.4, 0.0])
    assert model.step(x, [], 0.8)[:2] == pytest.approx(expected, abs=1e-12)
    end = reference(model, x, np.array([0.0, 0.8]))[-1]
    assert end[:2] == pytest.approx(expected, abs=1e-10)


def test_bounces_without_end_are_an_error_that_names_them() -> None:
    model, rest = ball().model(), Ball(1.0, 0.0, 0.7, 9.81).rest_time
    with pytest.raises(SingularError, match=r"without end \(bounce\)"):
        model.step([1.0, 0.0, 0.0], [], 3.0)
    with pytest.raises(KinolabError, match=rf"beyond t = {rest:.6g}.*without end: bounce"):
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
    """A landing foot stops dead; it leaves when the ground would have to pull."""
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


def section_of(theta: float, theta_dot: float, psi_dot: float, slope: float) -> np.ndarray:
    """Return the state of the compass walker just after a heelstrike; psi = -theta."""
    stance, swing = theta - slope, -theta - slope  # from the vertical
    hip = np.array([-np.sin(stance), np.cos(stance)])
    hip_rate = -theta_dot * np.array([np.cos(stance), np.sin(stance)])
    return np.array([*hip, stance, swing, *hip_rate, theta_dot, psi_dot, 0.0])


def after_a_step(model: Model, start: np.ndarray, period: float) -> np.ndarray:
    """Return angles and rates of stance and swing leg, shape (4,), just after the step."""
    assert np.abs(model.constraint_residual(start)[:2]).max() < 1e-12
    x = reference(model, start, np.array([0.0, period - SECONDS, period + SECONDS]))
    assert (x[1, -1], x[2, -1]) == (0.0, 1.0)
    assert sum(model.energy(x[2])) < sum(model.energy(x[1]))
    return x[2, [3, 2, 7, 6]]


def test_a_compass_walks_the_gait_that_conserved_momenta_give() -> None:
    walker = Compass()
    section, period = compass_gait(walker, np.array([0.27, -1.09, -0.376]))
    start = section_of(*section, walker.gamma)
    end = after_a_step(compass_walker().model(), start, period)
    assert np.abs(end - start[[2, 3, 6, 7]]).max() < 1e-7


def simplest_gait_of(beta: float) -> np.ndarray:
    """Return theta, theta_dot and the period that repeat themselves, with feet of a mass beta."""
    slope = 0.009
    model = compass_walker(hip=1.0, leg=beta, place=1.0, slope=slope, g=1.0).model()

    def strike(section: np.ndarray) -> tuple[np.ndarray, float]:
        start = section_of(*section, slope)
        early, late = 3.0, 5.0
        for _ in range(36):
            t = 0.5 * (early + late)
            end = reference(model, start, np.array([0.0, t]))[-1]
            early, late = (early, t) if end[-1] else (t, late)
        end = reference(model, start, np.array([0.0, late]))[-1]
        return end[[3, 7, 6]] + [slope, 0, 0], late

    section = fsolve(lambda s: strike(s)[0] - s, [0.2, -0.2, -0.184], xtol=1e-9, epsfcn=1e-10)
    return np.array([*section[:2], strike(section)[1]])


def test_the_simplest_walker_walks_its_published_gait() -> None:
    """A compass whose legs weigh nothing but for feet, as these become light.

    Source: Garcia, Chatterjee, Ruina, Coleman, The simplest walking model, 1998: the long gait at a
    slope of 0.009. Feet of a mass beta change it by a multiple of beta, and by O(beta^2).
    """
    found = 2 * simplest_gait_of(1e-4) - simplest_gait_of(2e-4)
    assert np.abs(found - [0.2003109, -0.1998325, 3.8824636]).max() < 1e-6


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


def test_a_transition_that_is_undefined_is_an_error() -> None:
    z = length("z", -1.0, 10.0)
    model = System(
        "probe",
        bodies=[Body("probe", move(0, 0, z), mass=1.0)],
        gravity=toward("-z", 9.81),
        modes=[Mode("falls")],
        transitions=[Transition("wakes", "falls", "falls", until=sympy.log(z))],
    ).model()
    assert model.transition([2.0, -1.0, 0.0]) == ""
    assert model.transition([0.5, -1.0, 0.0]) == "wakes"
    for ask in (model.transition, model.reset):
        with pytest.raises(SingularError):
            ask([-0.5, -1.0, 0.0])
