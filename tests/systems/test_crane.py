"""The derived overhead crane against Newton's laws, a second engine and its flat output."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import kinolab
from kinolab import systems
from tests.oracles import crane as oracle
from tests.oracles.crane import Crane

Array = NDArray[np.float64]
Inputs = Callable[[float], Array]  # time in [s] -> (travel, traverse, hoist) in [N]

CRANE = Crane()
LIGHT = Crane(m=0.73, M_b=0.6, M_t=1.155, g=9.7, c_x=0.3, c_y=0.2, c_l=1.1, c_s=0.05)  # a desk's
FREE = replace(CRANE, c_x=0.0, c_y=0.0, c_l=0.0, c_s=0.0)
HEAVY = replace(FREE, M_b=1e9, M_t=1e9)  # bridge and trolley move as they are told
AXES = {"x": 0, "y": 1}


@pytest.fixture(scope="module")
def model() -> Any:
    return systems.get("crane").model()


@pytest.fixture(scope="module")
def samples() -> tuple[Array, Array]:
    """One hundred random states (100, 10), swaying up to 1 rad, and inputs (100, 3) in weights."""
    rng = np.random.default_rng(1995)
    x = rng.uniform(-1, 1, (100, 10))
    x[:, 2] = rng.uniform(0.5, 8.0, 100)
    return x, rng.uniform(-1, 2, (100, 3))


def ordered(model: Any, x: Array) -> Array:
    """States in the oracle's order as the model wants them."""
    return x[..., [oracle.STATES.index(name) for name in model.state_names]]


def derivative(model: Any, x: Array, u: Array, crane: Crane) -> Array:
    """Return the model's x_dot for a state in the oracle's order, in that order."""
    moved = np.asarray(model.f(ordered(model, x), u, **asdict(crane)))
    return moved[..., [model.state_names.index(name) for name in oracle.STATES]]


def simulate(model: Any, start: Array, inputs: Inputs, t: Array, crane: Crane) -> Array:
    """States at times ``t`` in the oracle's order, shape (len(t), 10), by DOP853."""
    run = solve_ivp(
        lambda s, x: derivative(model, x, inputs(s), crane),
        (float(t[0]), float(t[-1])),
        start,
        "DOP853",
        t_eval=t,
        rtol=1e-11,
        atol=1e-11,
    )
    return np.asarray(run.y.T, dtype=np.float64)


def hanging(l: float = 5.0) -> Array:  # noqa: E741  # the rope's length
    """State at rest with the rope straight down, shape (10,)."""
    return np.array([0, 0, l, 0, 0, 0, 0, 0, 0, 0], dtype=np.float64)


def test_states_and_controls_carry_the_authors_names(model: Any) -> None:
    assert sorted(model.state_names) == sorted(oracle.STATES)
    assert tuple(model.control_names) == oracle.CONTROLS


# The equations of motion


@pytest.mark.parametrize("crane", [CRANE, LIGHT, FREE])
def test_derived_motion_obeys_newton_for_trolley_and_load(
    model: Any, samples: tuple[Array, Array], crane: Crane
) -> None:
    for x, weights in zip(*samples, strict=True):
        u = weights * crane.m * crane.g
        expected = oracle.state_derivative(x, u, crane)
        found = derivative(model, x, u, crane)
        assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("crane", [CRANE, LIGHT])
def test_derived_motion_equals_that_of_pinocchio(
    model: Any, samples: tuple[Array, Array], crane: Crane
) -> None:
    """Two slides, two hinges and a slide; only the generalised forces are typed in."""
    pin: Any = pytest.importorskip("pinocchio", reason="the second engine is not installed")
    tree = slides_and_hinges(pin, crane)
    for x, weights in zip(*samples, strict=True):
        u = weights * crane.m * crane.g
        q, v, force = x[PIN_ORDER], x[5:][PIN_ORDER], oracle.generalised_forces(x, u, crane)
        expected = pin.aba(tree, tree.createData(), q, v, force[PIN_ORDER])
        found = derivative(model, x, u, crane)[5:][PIN_ORDER]
        assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()


PIN_ORDER = [0, 1, 3, 4, 2]  # x, y, theta_x, theta_y, l: from the ground to the load


def slides_and_hinges(pin: Any, crane: Crane) -> Any:
    """Return the crane as a tree of joints; theta_x turns about -y, to swing towards +x."""
    tree, joint = pin.Model(), 0
    tree.gravity.linear = np.array([0, 0, -crane.g])
    turns = [pin.JointModelRevoluteUnaligned(0, -1, 0), pin.JointModelRX()]
    joints = [pin.JointModelPX(), pin.JointModelPY(), *turns]
    for kind in [*joints, pin.JointModelPrismaticUnaligned(0, 0, -1)]:
        joint = tree.addJoint(joint, kind, pin.SE3.Identity(), f"joint {joint + 1}")
    for place, mass in ((1, crane.M_b), (2, crane.M_t), (5, crane.m)):
        particle = pin.Inertia(mass, np.zeros(3), np.zeros((3, 3)))
        tree.appendBodyToJoint(place, particle, pin.SE3.Identity())
    return tree


def test_a_hanging_load_stays(model: Any) -> None:
    weight = np.array([0, 0, CRANE.m * CRANE.g])
    assert np.abs(derivative(model, hanging(), weight, CRANE)).max() < 1e-12


def test_the_rope_carries_the_winch_and_its_drag(model: Any, samples: tuple[Array, Array]) -> None:
    """The only margin is the tension: lowering faster stretches the rope, it never pushes."""
    for x, weights in zip(*samples, strict=True):
        u = weights * CRANE.m * CRANE.g
        margins = np.asarray(model.requirements(ordered(model, x), u, **asdict(CRANE)))
        assert margins.shape == (1,)
        assert margins[0] == pytest.approx(oracle.tension(x, u, CRANE), rel=1e-12)  # [N]


def test_a_winch_that_runs_free_lets_the_load_fall(model: Any) -> None:
    """Paying out rope without a force, it leaves the load a parabola, whatever the trolley does."""
    crane = replace(CRANE, c_s=0.0)

    def slope(t: float, x: Array) -> Array:
        u = np.array([900 * np.sin(2 * t), 400.0, -crane.c_l * x[7]])
        margin = model.requirements(ordered(model, x), u, **asdict(crane))
        assert np.abs(margin).max() < 1e-9  # [N]: the rope is slack
        return derivative(model, x, u, crane)

    t = np.linspace(0.0, 1.0, 11)
    run = solve_ivp(slope, (0, 1), SWINGING, "DOP853", t_eval=t, rtol=1e-12, atol=1e-12)
    thrown = oracle.rope_rate(SWINGING) + np.array([*SWINGING[5:7], 0])
    fallen = np.outer(t**2 / 2, [0, 0, -crane.g])
    expected = oracle.load(SWINGING) + np.outer(t, thrown) + fallen
    np.testing.assert_allclose(oracle.load(run.y.T), expected, rtol=0, atol=1e-9)  # [m]


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize(("angle", "speed"), [(0.0, 0.0), (0.4, 0.0), (0.2, -0.7), (0.0, 1.0)])
def test_a_swing_on_a_held_rope_pulls_with_weight_and_centripetal_force(
    model: Any, axis: str, angle: float, speed: float
) -> None:
    """m (g cos s + l s_dot^2) keeps the length under a trolley that stays."""
    x = hanging(4.0)
    x[3 + AXES[axis]], x[8 + AXES[axis]] = angle, speed
    pull = HEAVY.m * (HEAVY.g * np.cos(angle) + 4.0 * speed**2)
    u = np.array([0, 0, pull])
    found = derivative(model, x, u, HEAVY)[7]
    assert found == pytest.approx(0.0, abs=1e-4)  # [m/s^2]; trolleys of 1e9 kg give way by 1e-5
    margin = model.requirements(ordered(model, x), u, **asdict(HEAVY))
    assert float(margin[0]) == pytest.approx(pull)


def test_a_hall_looks_the_same_from_everywhere_along_its_rails(model: Any) -> None:
    """Shifting bridge and trolley shifts the whole motion."""
    shift, t = np.array([7.0, -3.0, *np.zeros(8)]), np.linspace(0.0, 4.0, 21)

    def inputs(time: float) -> Array:
        return np.array([900 * np.sin(2 * time), 400 * np.cos(time), 9810 + 600 * np.sin(3 * time)])

    path = simulate(model, SWINGING, inputs, t, CRANE)
    image = simulate(model, SWINGING + shift, inputs, t, CRANE)
    np.testing.assert_allclose(image, path + shift, rtol=0, atol=1e-9)  # 100 times rtol


def test_the_cable_that_is_drawn_is_the_rope(model: Any, samples: tuple[Array, Array]) -> None:
    """From the trolley, always at one height, to the load."""
    heights = []
    for x in samples[0]:
        (top, bottom), *_ = np.asarray(model.cables(ordered(model, x)))
        np.testing.assert_allclose(bottom - top, oracle.rope(x), rtol=0, atol=1e-12)
        np.testing.assert_allclose(top[:2], x[:2], rtol=0, atol=1e-12)
        heights.append(top[2])
    assert np.ptp(heights) < 1e-12  # [m]


# Energy


@pytest.mark.parametrize("crane", [CRANE, LIGHT])
def test_energies_are_those_of_the_particles(
    model: Any, samples: tuple[Array, Array], crane: Crane
) -> None:
    """The potential up to a constant, m g times the load's height."""
    constants = []
    for x in samples[0]:
        kinetic, potential = model.energy(ordered(model, x), **asdict(crane))
        assert float(kinetic) == pytest.approx(oracle.kinetic_energy(x, crane), rel=1e-12)
        constants.append(float(potential) - crane.m * crane.g * oracle.load(x)[2])
    assert np.ptp(constants) < 1e-11 * crane.m * crane.g  # [J], heights to 1e-11 m


SWINGING = np.array([0.0, 0.0, 5.0, 0.3, -0.2, 0.4, -0.3, 0.1, 0.2, 0.4])


def energies(model: Any, path: Array, crane: Crane) -> Array:
    """Kinetic and potential energy along a path in [J], shape (len(path), 2)."""
    return np.array([model.energy(ordered(model, x), **asdict(crane)) for x in path], dtype=float)


@pytest.mark.parametrize("share", [0.0, 0.9, 1.0])
def test_a_crane_without_drag_keeps_its_energy(model: Any, share: float) -> None:
    """A constant tension has the potential hoist l; drift is integration error, rtol 1e-11."""
    hoist = share * FREE.m * FREE.g
    t = np.linspace(0.0, 4.0, 41)
    path = simulate(model, SWINGING, lambda _: np.array([0, 0, hoist]), t, FREE)
    shares = energies(model, path, FREE)
    total = shares.sum(axis=1) + hoist * path[:, 2]
    assert np.abs(total - total[0]).max() < 1e-9 * np.ptp(shares[:, 1])


def test_energy_changes_by_the_work_of_drives_and_drags(model: Any) -> None:
    def inputs(t: float) -> Array:
        return np.array([900 * np.sin(2 * t), 400 * np.cos(t), 9810 + 600 * np.sin(3 * t)])

    def slope(t: float, both: Array) -> Array:
        x, u = both[:10], inputs(t)
        power = oracle.generalised_forces(x, u, CRANE) @ x[5:]
        return np.append(derivative(model, x, u, CRANE), power)

    start = np.append(SWINGING, 0.0)
    run = solve_ivp(slope, (0, 6), start, "DOP853", max_step=0.1, rtol=1e-11, atol=1e-11)
    total = energies(model, run.y[:10].T, CRANE).sum(axis=1)
    work = run.y[10]
    assert np.ptp(work) > 1000.0  # [J]: drives and drags matter
    assert np.abs(total - total[0] - work).max() < 1e-9 * np.ptp(work)


# Small sway


def frequencies(model: Any, l: float, crane: Crane) -> Array:  # noqa: E741
    """Angular frequencies in [rad/s] of the linearisation about hanging, ascending."""
    u = np.array([0, 0, crane.m * crane.g])
    A, _ = model.jacobian(ordered(model, hanging(l)), u, **asdict(crane))
    values = np.linalg.eigvals(A)
    assert np.abs(values.real).max() < 1e-6  # [1/s]; a double zero splits by sqrt(rounding)
    return np.sort(values.imag[values.imag > 1e-3])


@pytest.mark.parametrize("l", [0.5, 2.0, 5.0, 8.0])
def test_a_load_on_a_free_trolley_sways_faster(model: Any, l: float) -> None:  # noqa: E741
    expected = np.sort(oracle.sway_frequencies(l, FREE))
    np.testing.assert_allclose(frequencies(model, l, FREE), expected, rtol=1e-9)


@pytest.mark.parametrize("l", [0.5, 2.0, 5.0, 8.0])
def test_a_load_on_a_held_trolley_sways_as_a_pendulum(model: Any, l: float) -> None:  # noqa: E741
    """Bridge and trolley of 1e9 kg give way by m / M = 1e-6."""
    found = frequencies(model, l, HEAVY)
    np.testing.assert_allclose(found, np.sqrt(HEAVY.g / l) * np.ones(2), rtol=1e-6)


# Shaped commands

GENTLE = 0.02  # [m/s^2]: sways by 4 mrad; the rope gives way by a^2 / g, its period by 1e-4
Pulse = tuple[float, float, float]  # from, to in [s], acceleration in [m/s^2]


def commanded(pulses: Sequence[Pulse], axis: str, t: float) -> Array:
    """Forces on the heavy bridge or trolley that accelerate it by the sum of the pulses."""
    wanted = sum(a for begin, end, a in pulses if begin <= t < end)
    u = np.array([0, 0, HEAVY.m * HEAVY.g])
    u[AXES[axis]] = wanted * (HEAVY.M_b + HEAVY.M_t if axis == "x" else HEAVY.M_t)
    return u


def sway_after(model: Any, pulses: Sequence[Pulse], axis: str) -> tuple[float, float]:
    """Return the amplitude in [rad] after the last pulse, and the largest angle until then."""
    times = sorted({0.0, *(moment for pulse in pulses for moment in pulse[:2])})
    x, peak = hanging(), 0.0
    for begin, end in pairwise(times):
        u = commanded(pulses, axis, begin)
        path = simulate(model, x, lambda _, u=u: u, np.linspace(begin, end, 50), HEAVY)
        x = path[-1]
        peak = max(peak, float(np.abs(path[:, 3 + AXES[axis]]).max()))
    angle, speed = x[3 + AXES[axis]], x[8 + AXES[axis]]
    return float(np.hypot(angle, speed / np.sqrt(HEAVY.g / x[2]))), peak


def period() -> float:
    """Return the small-angle period of the held pendulum in [s]."""
    return float(2 * np.pi * np.sqrt(hanging()[2] / HEAVY.g))


@pytest.mark.parametrize("axis", AXES)
def test_a_pulse_of_one_period_leaves_no_sway(model: Any, axis: str) -> None:
    amplitude, peak = sway_after(model, [(0.0, period(), GENTLE)], axis)
    assert peak == pytest.approx(2 * GENTLE / HEAVY.g, rel=1e-2)  # the load did sway
    assert amplitude < 1e-3 * peak


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("periods", [0.25, 0.5, 1.5, 1.8])
def test_a_pulse_of_another_length_leaves_the_sway_of_a_pendulum(
    model: Any, axis: str, periods: float
) -> None:
    duration = periods * period()
    amplitude, peak = sway_after(model, [(0.0, duration, GENTLE)], axis)
    expected = oracle.residual_sway(GENTLE, duration, 2 * np.pi / period(), HEAVY.g)
    assert amplitude == pytest.approx(expected, abs=1e-3 * peak)
    assert amplitude > 0.5 * GENTLE / HEAVY.g


@pytest.mark.parametrize("axis", AXES)
def test_two_halves_half_a_period_apart_leave_no_sway(model: Any, axis: str) -> None:
    """The zero-vibration shaper: the second half's sway is opposite to the first half's."""
    plain = [(0.0, 1.3, GENTLE), (1.3, 2.0, -2 * GENTLE)]
    later = period() / 2
    shaped = [(a + d, b + d, size / 2) for a, b, size in plain for d in (0.0, later)]
    left, _ = sway_after(model, plain, axis)
    shaped_left, peak = sway_after(model, shaped, axis)
    assert left > peak  # without shaping
    assert shaped_left < 1e-3 * peak


# Flatness

DURATION = 9.0  # [s]


def carried(crane: Crane) -> oracle.FlatMotion:
    """Motion of a load around a corner, lifted and lowered on the way, from rest to rest."""
    t = sp.Symbol("t")
    tau = t / sp.Float(DURATION)
    s, aside = oracle.rest_to_rest(tau), oracle.detour(tau)
    path = [1 + 7 * s, -2 + 3 * s + sp.Float(1.5) * aside, -6 + sp.Float(1.5) * s + 2 * aside]
    return oracle.flat_motion(path, t, crane)


@pytest.mark.parametrize("crane", [FREE, replace(CRANE, c_s=0.0), replace(LIGHT, c_s=0.0)])
def test_inputs_of_the_flat_output_carry_the_load_along_its_path(model: Any, crane: Crane) -> None:
    """Open loop over 9 s; rtol 1e-11 of 10 m, over double integrators of 9 s, is far below 1e-6."""
    motion = carried(crane)
    t = np.linspace(0.0, DURATION, 91)
    planned = np.array([motion(time)[0] for time in t])
    loads = np.array([motion(time)[2] for time in t])
    path = simulate(model, planned[0], lambda time: motion(time)[1], t, crane)
    assert np.abs(oracle.load(path) - loads).max() < 1e-6  # [m]
    np.testing.assert_allclose(path, planned, rtol=0, atol=1e-6)


def test_the_flat_motion_starts_and_ends_at_rest_and_sways_between() -> None:
    motion = carried(CRANE)
    weight = [0, 0, CRANE.m * CRANE.g]
    for time, place in ((0.0, [1, -2, -6]), (DURATION, [8, 1, -4.5])):
        x, u, p = motion(time)
        np.testing.assert_allclose(p, place, rtol=0, atol=1e-9)
        np.testing.assert_allclose(x, [*place[:2], -place[2], *np.zeros(7)], rtol=0, atol=1e-9)
        np.testing.assert_allclose(u, weight, rtol=0, atol=1e-5)  # [N] of 1e4
    between = np.array([motion(time)[0] for time in np.linspace(0, DURATION, 91)])
    assert (np.abs(between[:, 3:5]).max(axis=0) > 0.05).all()  # [rad]
    assert np.ptp(between[:, 2]) > 1.0  # [m]: the rope is hauled in and paid out


def test_the_rope_hits_a_pipe_that_the_package_has_passed() -> None:
    """In the factory, with the package below the overhead pipes and the trolley above them."""
    problem = kinolab.load("crane_factory")
    x = problem.start.copy()
    for name, value in {"x": 14.0, "y": 4.2, "l": 7.0}.items():
        x[problem.model.state_names.index(name)] = value
    (contact,) = problem.checker().contacts(*problem.placement(x))
    assert (contact.body, contact.obstacle, contact.kind) == ("rope", "pipes", "touches")
