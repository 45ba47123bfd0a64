"""The variational integrator: what it keeps, how fast it converges, and what it refuses."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from scipy.special import ellipk

from kinolab.dynamics import (
    Body,
    Buoyancy,
    System,
    length,
    move,
    orient,
    rotation,
    toward,
)
from kinolab.errors import (
    InputError,
    NoDynamicsError,
    SingularError,
    UnknownNameError,
)
from tests import machines, registered
from tests.dynamics.variational_integrator import VariationalIntegrator
from tests.machines import MACHINES

Array = NDArray[np.float64]

ROUNDING = 1e-11  # relative; 100 000 steps lose a few digits of 1e-16
INERTIA = np.array([1.0, 2.0, 3.0])  # [kg m^2]


def rigid_body() -> System:
    """A body that is held at its centre and turns as it likes."""
    return System("rigid_body", bodies=[Body("b", orient(rotation("R")), inertia=(1, 2, 3))])


def heavy_top() -> System:
    """A symmetric top on its tip, on SO(3): its weight depends on the attitude."""
    top = orient(rotation("R")) @ move(0, 0, 0.3)
    body = Body("top", top, mass=1.5, inertia=(0.02, 0.02, 0.01))
    return System("heavy_top", bodies=[body], gravity=toward("-z", 9.81))


def drifting_hull() -> System:
    """A bottom-heavy hull in an ideal fluid without drag: added mass and buoyancy on SE(3)."""
    x, y, z, R = length("x"), length("y"), length("z"), rotation("R")
    hull = move(x, y, z) @ orient(R)
    (hull_body,) = machines.finned_hull().bodies
    body = Body("hull", hull, mass=10.0, inertia=(0.3, 1.2, 1.3), added_mass=hull_body.added_mass)
    lift = Buoyancy(on=body, lift=98.1, at=(0, 0, 0.05))
    return System("drifting_hull", bodies=[body], gravity=toward("-z", 9.81), efforts=[lift])


OWN = (rigid_body, heavy_top, drifting_hull)
MAKERS: dict[str, Callable[[], System]] = {**MACHINES, **{make.__name__: make for make in OWN}}
MAKERS |= registered.MAKERS

REFUSED = {
    "finned_hull": (InputError, "a wrench"),
    "driven_crane": (InputError, "the drive 'trolley_drive'"),
    "sprung_cart": (InputError, "the auxiliary state 'thrust'"),
    "kinematic_car": (NoDynamicsError, "it has no energy"),
    "two_cranes": (InputError, "the drive 'travel_a'"),
    "marionette": (InputError, "the drive 'push_x'"),
    "car": (InputError, "friction"),
    "crane": (InputError, "friction"),
    "diff_drive": (InputError, "friction"),
    "slip_steered": (InputError, "friction"),
    "snakeboard": (InputError, "friction"),
    "submarine": (InputError, "a wrench"),
    "motorcycle": (InputError, "the drive 'steer'"),
    **dict.fromkeys(("helicopter", "submarine"), (InputError, "a wrench")),
    **dict.fromkeys(("satellite", "satellite_two_wheels"), (InputError, "friction")),
    **dict.fromkeys(("quad2d_v0", "quad2dpole_v0"), (InputError, "a wrench")),
    **dict.fromkeys(("quad3d_v0", "quad3d_omplapp"), (InputError, "a wrench")),
    **{f"unicycle1_v{k}": (NoDynamicsError, "it has no energy") for k in range(3)},
    **dict.fromkeys(("unicycle2_v0", "car1_v0"), (NoDynamicsError, "it has no energy")),
    **dict.fromkeys(("biped, left", "biped, right"), (NoDynamicsError, "it has no energy")),
}
SERVED = [name for name in MAKERS if name not in REFUSED]

# Inside the charts, and on their wheels; what is left out is at rest() plus a random 0.4.
STARTS = {
    "falling_disk": {"theta": 0.1, "phi_dot": 6.0},
    "unicycle": {"theta": 0.1, "theta_dot": 0.0, "alpha": -0.02, "alpha_dot": 0.3},
    "four_bar": {"a": 0.7, "b": 0.5, "c": 1.5},
    "four_bar_by_multipliers": {"a": 0.7, "b": 0.5, "c": 1.5},
    "rope_pendulum": {"x": 0.3, "y": -0.9},
    "loose_snakeboard": {"th": 0.3, "phi_b": 0.5, "phi_f": -0.4},
}
SHARES = {"loose_snakeboard": 1e-3, "unicycle": 1e-2}  # light wheels turn by 150 rad/s^2 else
DURATION = 0.4  # [s]


@cache
def integrator(name: str) -> VariationalIntegrator:
    return VariationalIntegrator(MAKERS[name]())


def start_of(name: str) -> Array:
    """Return a moving state on the constraints; the projection converges in a few calls."""
    model = integrator(name).model
    x = model.rest() + 0.4 * np.random.default_rng(3).standard_normal(model.nx)
    for coordinate, value in STARTS.get(name, {}).items():
        x[model.state_names.index(coordinate)] = value
    for _ in range(10):
        x = model.project(x)
    return x


def held_inputs(name: str) -> Array:
    bounds = integrator(name).model.control_bounds
    pushes: Array = SHARES.get(name, 0.1) * bounds[:, 1]
    return pushes


def columns(name: str, travel: Array) -> dict[str, Array]:
    return dict(zip(integrator(name).model.state_names, travel.T, strict=True))


# Accuracy


@pytest.mark.parametrize("pushed", [False, True], ids=["free", "pushed"])
@pytest.mark.parametrize("name", SERVED)
def test_it_converges_to_the_equations_of_motion(name: str, pushed: bool) -> None:
    """Second order: half the step, a quarter of the error, and what remains is of fourth order."""
    moves, x = integrator(name), start_of(name)
    u = held_inputs(name) if pushed else np.zeros(moves.model.nu)
    exact = solve_ivp(
        lambda _, y: moves.model.f(y, u), (0, DURATION), x, method="DOP853", rtol=1e-12, atol=1e-13
    ).y[:, -1]
    coarse, fine = (moves.run(x, DURATION / n, n, u)[-1] for n in (80, 160))
    errors = [np.abs(end - exact).max() for end in (coarse, fine)]
    assert 1e-10 < errors[1] < 1e-2  # [m], [rad] or those per s; far above the reference's error
    assert 3.8 < errors[0] / errors[1] < 4.2
    extrapolated = np.abs((4 * fine - coarse) / 3 - exact).max()
    assert extrapolated < 0.02 * errors[1]


@pytest.mark.parametrize("name", SERVED)
def test_it_is_its_own_inverse_for_negative_steps(name: str) -> None:
    moves, x = integrator(name), start_of(name)
    there = moves.run(x, 0.004, 100, held_inputs(name))
    back = moves.run(there[-1], -0.004, 100, held_inputs(name))
    np.testing.assert_allclose(back[::-1], there, rtol=0, atol=1e-10)  # rounding of 200 solutions


def test_a_pendulum_obeys_the_discrete_euler_lagrange_equation() -> None:
    """Marsden and West, section 1.3, with the midpoint rule written out by hand."""
    h, g, l = 0.05, 9.81, 0.7  # noqa: E741
    theta = integrator("pendulum").run([2.0, 1.0], h, 200, l=l)[:, 0]
    pull = np.sin((theta[1:] + theta[:-1]) / 2) * g / l
    left = (theta[2:] - 2 * theta[1:-1] + theta[:-2]) / h**2
    right = -(pull[1:] + pull[:-1]) / 2
    np.testing.assert_allclose(left, right, rtol=0, atol=1e-10)  # [rad/s^2]; rounding over h^2


def top_action(before: Rotation, after: Rotation, h: float) -> float:
    """h L of the heavy top: half of the way is the Cayley map of h w / 2, by its tan(angle / 2)."""
    half = Rotation.from_rotvec((before.inv() * after).as_rotvec() / 2)
    w = 4 / h * half.as_quat()[:3] / half.as_quat()[3]
    about_tip = np.array([0.02 + 1.5 * 0.3**2, 0.02 + 1.5 * 0.3**2, 0.01])
    height = (before * half).apply([0, 0, 0.3])[2]
    return float(h * (0.5 * about_tip @ w**2 - 1.5 * 9.81 * height))


def test_a_heavy_top_makes_the_discrete_action_stationary() -> None:
    """Hamilton's principle itself, with the action written out by hand and varied by 1e-4 rad."""
    h, d = 0.05, 1e-4
    x = np.array([*Rotation.from_euler("x", 0.6).as_quat(), 3.0, -2.0, 20.0])
    first, middle, last = Rotation.from_quat(integrator("heavy_top").run(x, h, 2)[:, :4])

    def action(variation: Array) -> float:
        varied = middle * Rotation.from_rotvec(variation)
        return top_action(first, varied, h) + top_action(varied, last, h)

    slope = [(action(d * e) - action(-d * e)) / (2 * d) for e in np.eye(3)]
    np.testing.assert_allclose(slope, 0, atol=1e-7)  # [N m s]; its parts are about 0.3


def test_a_pendulum_keeps_areas_of_phase_space() -> None:
    """Symplectic: the determinant is 1, to what differences over 1e-5 can tell."""
    moves, x, d = integrator("pendulum"), np.array([2.0, 1.0]), 1e-5
    ends = [
        moves.run(x + d * e, 0.1, 10)[-1] - moves.run(x - d * e, 0.1, 10)[-1] for e in np.eye(2)
    ]
    assert np.linalg.det(np.array(ends) / (2 * d)) == pytest.approx(1.0, abs=1e-7)


@pytest.mark.parametrize("name", ["double_pendulum_3d", "loose_snakeboard", "heavy_top"])
def test_a_run_is_its_steps(name: str) -> None:
    """A step begins from the state alone; a run carries momenta along, which rounds otherwise."""
    moves, x = integrator(name), start_of(name)
    travel = moves.run(x, 0.01, 5)
    for row in travel[1:]:
        x = moves.step(x, 0.01)
        np.testing.assert_allclose(x, row, rtol=0, atol=1e-12)


# What symmetries keep


def tumble_period(w: Array) -> float:
    """Period of w of a free body for 2 E I_2 < L^2. Source: Landau, Lifshitz, Mechanics, 37.12."""
    I, energy, square = INERTIA, INERTIA @ w**2, (INERTIA * w) @ (INERTIA * w)  # noqa: E741
    spread = (I[2] - I[1]) * (square - energy * I[0])
    modulus = (I[1] - I[0]) * (energy * I[2] - square) / spread
    return float(4 * ellipk(modulus) * np.sqrt(I.prod() / spread))


def tumble(h: float, duration: float) -> tuple[Array, Array]:
    """Return spatial momentum (n, 3) and relative energy error (n,) of a 1 s tumble about y."""
    w = np.array([0.01, 1.0, 0.01])
    x = np.array([0, 0, 0, 1, *(w * tumble_period(w))])  # time scales with the spin
    travel = integrator("rigid_body").run(x, h, round(duration / h))
    spins = travel[:, 4:]
    energy = 0.5 * spins**2 @ INERTIA
    return Rotation.from_quat(travel[:, :4]).apply(spins * INERTIA), energy / energy[0] - 1


def test_a_tumbling_body_keeps_its_spatial_momentum_for_a_thousand_seconds() -> None:
    momentum, _ = tumble(0.01, 1000.0)  # a hundred steps per period
    drift = np.abs(momentum - momentum[0]).max() / np.linalg.norm(momentum[0])
    assert drift < ROUNDING


def test_the_energy_of_a_tumbling_body_swings_and_does_not_drift() -> None:
    """Over a thousand periods: the means of periods have no slope, both halves swing alike."""
    _, error = tumble(0.01, 1000.0)
    swing = np.ptp(error)
    assert 1e-3 < swing < 1e-2  # relative; the body turns by 0.4 rad in a step
    means = error[:-1].reshape(1000, 100).mean(axis=1)
    time = np.arange(1000) - 499.5
    slope = time @ means / (time @ time)
    scatter = np.sqrt(((means - means.mean() - slope * time) ** 2).sum() / 998 / (time @ time))
    assert abs(slope) < 2 * scatter
    assert abs(slope) * 1000 < 1e-3 * swing
    halves = np.ptp(error[:50_000]), np.ptp(error[50_000:])
    assert halves[0] == pytest.approx(halves[1], rel=1e-3)


def test_the_energy_error_of_a_tumbling_body_is_of_second_order() -> None:
    swings = [np.ptp(tumble(h, 100.0)[1]) for h in (0.01, 0.005, 0.0025)]
    ratios = np.array(swings[:-1]) / swings[1:]
    np.testing.assert_allclose(ratios, 4.0, rtol=0.05)  # what the next even order adds


def test_a_heavy_top_keeps_its_vertical_momentum_and_its_spin() -> None:
    """Both symmetries of Lagrange's top are the integrator's too, at any step."""
    x = np.array([*Rotation.from_euler("x", 0.6).as_quat(), 0.3, -0.2, 60.0])
    travel = integrator("heavy_top").run(x, 2e-3, 20_000)
    about_tip = np.array([0.02 + 1.5 * 0.3**2, 0.02 + 1.5 * 0.3**2, 0.01])
    momentum = travel[:, 4:] * about_tip
    vertical = Rotation.from_quat(travel[:, :4]).apply(momentum)[:, 2]
    for kept in (vertical, momentum[:, 2]):
        np.testing.assert_allclose(kept, kept[0], rtol=ROUNDING)


def test_a_hull_keeps_its_wheels_momenta_and_its_own() -> None:
    """A wheel's angle and the attitude are cyclic: four momenta, from the machine's numbers."""
    x = np.array([0, 0, 0, 1, 0.1, 0.2, 0.3, 0.4, -0.3, 0.2, 5.0, -8.0, 3.0])
    travel = integrator("wheeled_hull").run(x, 0.02, 20_000)
    turned, spins, wheels = Rotation.from_quat(travel[:, [0, 1, 2, 3]]), *_wheeled_rates(travel)
    own = 0.01 * (spins + wheels)
    np.testing.assert_allclose(own, np.tile(own[0], (len(own), 1)), rtol=ROUNDING)
    # Hull and wheels: each wheel's moments across its axis, and 1 kg at 0.2, 0.3, 0.4 m.
    across = 0.6 * 0.01 * 2
    places = np.array([0.2, 0.3, 0.4]) ** 2
    rigid = np.array([10.0, 12.0, 8.0]) + across + places.sum() - places
    momentum = turned.apply(spins * rigid + own)
    assert np.abs(momentum - momentum[0]).max() < ROUNDING * np.linalg.norm(momentum[0])


def _wheeled_rates(travel: Array) -> tuple[Array, Array]:
    named = columns("wheeled_hull", travel)
    spins = np.stack([named[f"R_w{axis}"] for axis in "xyz"], axis=1)
    return spins, np.stack([named[f"wheel_{axis}_dot"] for axis in "xyz"], axis=1)


def test_a_falling_body_gains_exactly_its_weight_as_momentum() -> None:
    x = start_of("floating_satellite")
    named = columns("floating_satellite", integrator("floating_satellite").run(x, 0.01, 1000))
    time = 0.01 * np.arange(1001)
    for axis, gain in (("x", 0.0), ("y", 1.6), ("z", 0.0)):
        speed = named[f"{axis}_dot"]
        np.testing.assert_allclose(speed, speed[0] + gain * time, rtol=0, atol=1e-11)  # [m/s]


def test_the_energy_of_a_four_bar_loop_does_not_drift() -> None:
    """Symplectic under constraints of position too: 500 s, a few hundred swings."""
    moves = integrator("four_bar")
    x = start_of("four_bar")
    travel = moves.run(x, 0.005, 100_000)
    kinetic, potential = moves.model.energy(travel[::10])
    energy = kinetic + potential
    halves = np.ptp(energy[:5000]), np.ptp(energy[5000:])
    assert halves[0] < 0.05 * np.ptp(potential)
    assert halves[1] == pytest.approx(halves[0], rel=0.2)  # the extremes of many swings


# Constraints


@pytest.mark.parametrize("name", ["four_bar", "four_bar_by_multipliers"])
def test_a_loop_stays_closed(name: str) -> None:
    named = columns(name, integrator(name).run(start_of(name), 0.01, 1000))
    a, b, c = named["a"], named["b"], named["c"]
    gap_x = 0.4 * np.cos(a) + np.cos(a + b) - 1 - 0.8 * np.cos(c)
    gap_y = 0.4 * np.sin(a) + np.sin(a + b) - 0.8 * np.sin(c)
    assert max(np.abs(gap_x).max(), np.abs(gap_y).max()) < 1e-10  # [m]


def test_all_rates_of_a_loop_keep_it_closed() -> None:
    name = "four_bar_by_multipliers"
    moves = integrator(name)
    excess = moves.model.constraint_residual(moves.run(start_of(name), 0.01, 1000))
    assert np.abs(excess).max() < 1e-10  # [m/s] and [m]


def coin_slip(q: dict[str, Array], rates: dict[str, Array]) -> Array:
    """Sideways and rolling slip of the coin, from its textbook constraints, in [m/s]."""
    along = np.cos(q["psi"]) * rates["x"] + np.sin(q["psi"]) * rates["y"]
    aside = np.cos(q["psi"]) * rates["y"] - np.sin(q["psi"]) * rates["x"]
    return np.array([aside, along - 0.25 * rates["phi"]])


def board_slip(q: dict[str, Array], rates: dict[str, Array]) -> Array:
    """Sideways slip of the snakeboard's wheels, 0.2 m behind and before its centre, in [m/s]."""
    slips = []
    for wheel, arm in (("phi_b", -0.2), ("phi_f", 0.2)):
        heading = q["th"] + q[wheel]
        aside = np.cos(heading) * rates["y"] - np.sin(heading) * rates["x"]
        slips.append(aside + arm * np.cos(q[wheel]) * rates["th"])
    return np.array(slips)


SLIPS = {"rolling_disk": coin_slip, "loose_snakeboard": board_slip}


@pytest.mark.parametrize("name", SLIPS)
def test_wheels_do_not_slip_at_midpoints(name: str) -> None:
    """The discrete constraint A((q0 + q1) / 2) (q1 - q0) / h = 0."""
    h, x, u = 0.01, start_of(name), held_inputs(name)
    named = columns(name, integrator(name).run(x, h, 500, u))
    middle = {key: (value[1:] + value[:-1]) / 2 for key, value in named.items()}
    mean = {key: np.diff(value) / h for key, value in named.items()}
    assert np.abs(SLIPS[name](middle, mean)).max() < 1e-10  # [m/s]


@pytest.mark.parametrize("name", SLIPS)
def test_the_slip_of_the_path_at_its_states_is_of_second_order(name: str) -> None:
    """By central differences of the states; their own velocities do not slip at all."""
    slips, x, u = [], start_of(name), held_inputs(name)
    for h, every in ((0.02, 1), (0.01, 2), (0.005, 4)):  # seen at the same times
        named = columns(name, integrator(name).run(x, h, round(0.6 / h), u))
        here = {key: value[every:-every:every] for key, value in named.items()}
        centre = slice(every - 1, 1 - every or None, every)
        rates = {k: ((v[2:] - v[:-2]) / (2 * h))[centre] for k, v in named.items()}
        slips.append(np.abs(SLIPS[name](here, rates)).max())
    np.testing.assert_allclose(np.divide(slips[:-1], slips[1:]), 4.0, rtol=0.05)


@pytest.mark.parametrize("name", ["rolling_disk", "loose_snakeboard", "trident_snake"])
def test_the_velocities_of_states_do_not_slip(name: str) -> None:
    moves = integrator(name)
    travel = moves.run(start_of(name), 0.01, 200)
    assert np.abs(moves.model.constraint_residual(travel)).max() < 1e-12  # [m/s]


# What is refused


@pytest.mark.parametrize("name", REFUSED)
def test_a_machine_that_is_not_conservative_is_refused(name: str) -> None:
    kind, cause = REFUSED[name]
    with pytest.raises(kind, match=cause):
        VariationalIntegrator(MAKERS[name]())


def test_the_refusal_names_everything_and_says_what_would_work() -> None:
    with pytest.raises(InputError) as caught:
        VariationalIntegrator(machines.driven_crane())
    assert str(caught.value) == (
        "system 'driven_crane': a variational integrator does not serve friction."
        " Leave it out, or use Model.step.\n"
        "system 'driven_crane': a variational integrator does not serve the drive 'trolley_drive'."
        " Leave it out, or use Model.step."
    )


@pytest.mark.parametrize(
    ("arguments", "cause"),
    [
        (([0.1, 0, 0], 0.1, 1), r"x0 has shape \(3,\); it must be \(2,\)"),
        (([0.1, 0], 0.0, 1), "the step is 0.0"),
        (([0.1, 0], np.inf, 1), "the step is inf"),
        (([0.1, 0], 0.1, 1, [1.0, 2.0]), r"u has shape \(2,\); it must be \(1,\)"),
        (([0.1, 0], 0.1, -1), "the run has -1 steps"),
    ],
)
def test_a_wrong_argument_is_named(arguments: tuple[Any, ...], cause: str) -> None:
    with pytest.raises(InputError, match=cause):
        integrator("pendulum").run(*arguments)


def test_an_unknown_parameter_is_named() -> None:
    with pytest.raises(UnknownNameError, match="'mass'"):
        integrator("pendulum").step([0.1, 0], 0.1, mass=2.0)


def test_a_start_off_the_constraints_is_refused() -> None:
    with pytest.raises(InputError, match=r"x0 misses its constraints by .*Model\.project"):
        integrator("four_bar").step([0.7, 0.5, 1.5, 0.0], 0.01)


@pytest.mark.parametrize(
    ("name", "h"), [("four_bar", 10.0), ("double_pendulum_3d", 100.0)], ids=["loop", "tree"]
)
def test_a_step_that_is_too_long_fails(name: str, h: float) -> None:
    with pytest.raises(SingularError, match="Take shorter steps"):
        integrator(name).run(start_of(name), h, 5)


def test_a_state_that_is_no_number_fails() -> None:
    with pytest.raises(SingularError, match="theta=nan"):
        integrator("pendulum").step([np.nan, 0.0], 0.01)
