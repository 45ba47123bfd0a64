"""The derived submarine against potential flow, Kirchhoff's equations and their invariants."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp

from kinolab import systems
from kinolab.dynamics import Model
from kinolab.errors import InputError
from kinolab.systems.submarine import added_mass_coefficients
from tests.oracles import submarine as oracle
from tests.oracles.submarine import Hull

Array: TypeAlias = NDArray[np.float64]
Inputs: TypeAlias = Callable[[float], Array]

SMOOTH = dict.fromkeys(["d_u", "d_v", "d_p", "d_q", "d_uu", "d_vv", "d_qq"], 0.0)
VISCOUS = SMOOTH | {"d_u": 20.0, "d_v": 110.0, "d_p": 3.0, "d_q": 40.0, "d_uu": 25.0}
COINCIDENT = SMOOTH | {"h": 0.0}
OTHER = VISCOUS | {"rho": 1025.0, "a": 1.7, "g": 9.7, "h": 0.05}
LAMB = (0.059121170898, 0.894260539590, 0.699851016030)  # of 5:1, along x, across, about y
RATES = ("x_dot", "y_dot", "z_dot", "R_wx", "R_wy", "R_wz")
QUATERNION = ("R_x", "R_y", "R_z", "R_w")
T = np.linspace(0.0, 20.0, 41)


@pytest.fixture(scope="module")
def model() -> Model:
    return systems.get("submarine").model()


@pytest.fixture(scope="module")
def samples() -> tuple[Array, Array, Array, Array]:
    """One hundred random places, attitudes (x, y, z, w), twists and inputs."""
    rng = np.random.default_rng(1997)
    quaternions = rng.normal(size=(100, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    places, twists = rng.uniform(-3, 3, (100, 3)), rng.uniform(-1, 1, (100, 6))
    return places, quaternions, twists, rng.uniform(-30, 30, (100, 3))


def hull(model: Model, **changes: float) -> Hull:
    """The oracle's vehicle with the model's parameters and some changes."""
    return Hull(**(model.system.parameter_values | changes))


def state(model: Model, place: Array, quaternion: Array, twist: Array) -> Array:
    """The model's state, its linear velocity along the world's axes."""
    velocity = oracle.rotation_matrix(quaternion) @ twist[:3]
    values = dict(zip("xyz", place, strict=True))
    values |= dict(zip(QUATERNION, quaternion, strict=True))
    values |= dict(zip(RATES, [*velocity, *twist[3:]], strict=True))
    return np.array([values[name] for name in model.state_names])


def upright(model: Model, **values: float) -> Array:
    """The rest state with some entries changed."""
    x = model.rest()
    for name, value in values.items():
        x[model.state_names.index(name)] = value
    return x


def pick(model: Model, x: Array, *names: str) -> Array:
    return np.asarray(x[..., [model.state_names.index(name) for name in names]])


def attitude(model: Model, x: Array) -> Array:
    """R of one state, shape (3, 3)."""
    return oracle.rotation_matrix(pick(model, x, *QUATERNION))


def twist_of(model: Model, x: Array) -> Array:
    """The twist along the body axes of one state, shape (6,)."""
    rates = pick(model, x, *RATES)
    return np.append(attitude(model, x).T @ rates[:3], rates[3:])


def run(model: Model, start: Array, t: Array, u: Inputs, **parameters: float) -> Array:
    """States at the times ``t``, shape (len(t), nx), by DOP853 near machine precision."""
    span = (float(t[0]), float(t[-1]))
    done = solve_ivp(
        lambda s, x: model.f(x, u(s), **parameters),
        span,
        start,
        "DOP853",
        t_eval=t,
        rtol=1e-13,
        atol=1e-13,
    )
    return np.asarray(done.y.T)


def idle(t: float) -> Array:  # noqa: ARG001
    return np.zeros(3)


def helm(t: float) -> Array:
    """Smooth inputs: forwards, with a little pitch and yaw both ways."""
    return np.array([30 + 10 * np.sin(0.5 * t), 2 * np.sin(0.7 * t), 3 * np.cos(0.4 * t)])


def tumble(model: Model) -> Array:
    """A start off every axis: drifting, tilted and turning about all three axes."""
    quaternion = np.array([0.2, -0.3, 0.4, 0.8])
    twist = np.array([0.3, -0.1, 0.15, 0.1, 0.15, 0.2])
    return state(model, np.array([1.0, 2.0, -3.0]), quaternion / np.linalg.norm(quaternion), twist)


# The oracles themselves


@pytest.mark.parametrize("axes", [(1.0, 1.0, 1.0), (5.0, 1.0, 1.0), (3.0, 2.0, 1.0)])
def test_lambs_coefficients_add_up_to_two(axes: ArrayLike) -> None:
    assert oracle.lamb_coefficients(np.array(axes)).sum() == pytest.approx(2.0, abs=1e-12)


def test_a_sphere_carries_half_of_its_fluid() -> None:
    """Stokes; an axis of symmetry carries none in turning."""
    factors = oracle.added_mass_factors(np.ones(3), oracle.lamb_coefficients(np.ones(3)))
    np.testing.assert_allclose(factors, [0.5, 0.5, 0.5, 0, 0, 0], rtol=0, atol=1e-12)


def test_quadrature_closed_form_and_potential_flow_give_the_same_added_mass() -> None:
    axes = np.array([5.0, 1.0, 1.0])
    closed = oracle.added_mass_factors(axes, oracle.spheroid_coefficients(5.0, 1.0))
    integral = oracle.added_mass_factors(axes, oracle.lamb_coefficients(axes))
    flow, misfit = oracle.potential_flow_factors(5.0, 1.0)
    np.testing.assert_allclose(integral, closed, rtol=1e-11, atol=1e-12)
    assert misfit < 1e-9  # of a hull that moves at 1 m/s
    np.testing.assert_allclose(flow, closed[[0, 2, 4]], rtol=1e-10)
    np.testing.assert_allclose(flow, LAMB, rtol=1e-10)


AXES = [
    (1.0, 1.0, 1.0),
    (5.0, 1.0, 1.0),  # prolate
    (1.0, 5.0, 1.0),
    (3.0, 3.0, 1.0),  # oblate
    (0.2, 1.0, 1.0),
    (3.0, 2.0, 1.0),
    (0.7, 2.3, 1.1),
    (1.0, 1.001, 1.002),  # nearly a sphere
]


@pytest.mark.parametrize("axes", AXES)
def test_added_mass_of_any_ellipsoid_is_lambs(axes: tuple[float, float, float]) -> None:
    """Against quadrature of Lamb's integrals; what turns carries the rounding of a difference."""
    integrals = oracle.lamb_coefficients(np.array(axes))
    found = np.array(added_mass_coefficients(*axes))
    expected = oracle.added_mass_factors(np.array(axes), integrals)
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-12)
    k = found[:3]
    assert (2 * k / (1 + k)).sum() == pytest.approx(2.0, abs=1e-13)  # alpha + beta + gamma


def test_added_mass_has_the_figures_of_lambs_table() -> None:
    """Spheroid 5:1 (.059, .895, .701) and sphere; the unit of the axes does not matter.

    The figures are those integrals by quadrature with 30 digits.
    """
    k1, k2, k5 = 0.0591211708978287, 0.8942605396198953, 0.6998510160300644
    expected = [k1, k2, k2, 0.0, k5, k5]
    for axes in ((5.0, 1.0, 1.0), (0.5, 0.1, 0.1)):
        np.testing.assert_allclose(added_mass_coefficients(*axes), expected, rtol=0, atol=1e-12)
    sphere = added_mass_coefficients(2.0, 2.0, 2.0)
    np.testing.assert_allclose(sphere, [0.5, 0.5, 0.5, 0, 0, 0], rtol=0, atol=1e-14)


def test_a_thin_disk_carries_the_fluid_of_the_textbook() -> None:
    """Broadside a disk of radius r adds 8/3 rho r^3, edgewise nothing (Lamb, section 114)."""
    thin = 1e-5
    edgewise, _, broadside, *_ = added_mass_coefficients(1.0, 1.0, thin)
    assert broadside * 4 / 3 * np.pi * thin == pytest.approx(8 / 3, rel=1e-4)
    assert edgewise == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize("axis", [0.0, -1.0, np.nan, np.inf, "1", None])
def test_an_ellipsoid_without_extent_is_refused(axis: Any) -> None:
    with pytest.raises(InputError, match="added_mass_coefficients b") as caught:
        added_mass_coefficients(1.0, axis, axis)
    assert len(caught.value.mistakes) == 2


# The equations of motion


@pytest.mark.parametrize("changes", [{}, {"rho": 1025.0, "a": 1.7}])
def test_mass_matrix_is_hull_and_fluid(model: Model, changes: dict[str, float]) -> None:
    assert model.rate_names == RATES
    expected = np.diag(hull(model, **changes).inertia)
    found = model.mass_matrix(model.rest(), **changes)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * expected.min(initial=1.0))


def test_added_mass_factors_are_lambs(model: Model) -> None:
    factors = np.diag(model.mass_matrix(model.rest())) / rigid(hull(model)) - 1
    k1, k2, k5 = LAMB
    np.testing.assert_allclose(factors, [k1, k2, k2, 0.0, k5, k5], rtol=1e-9, atol=1e-12)


def rigid(vehicle: Hull) -> Array:
    """Mass and moments of the hull alone: a homogeneous ellipsoid's, shape (6,)."""
    a2, b2 = vehicle.a**2, vehicle.a**2 / 25
    return vehicle.m * np.array([1, 1, 1, 2 * b2 / 5, (a2 + b2) / 5, (a2 + b2) / 5])


@pytest.mark.parametrize("parameters", [SMOOTH, COINCIDENT, VISCOUS, OTHER])
def test_motion_is_kirchhoffs(
    model: Model, samples: tuple[Array, ...], parameters: dict[str, float]
) -> None:
    vehicle = hull(model, **parameters)
    for place, quaternion, twist, u in zip(*samples, strict=True):
        R = oracle.rotation_matrix(quaternion)
        x = state(model, place, quaternion, twist)
        slope = model.f(x, u, **parameters)
        expected = oracle.accelerations(R, twist, u, vehicle)
        np.testing.assert_allclose(pick(model, slope, *RATES), expected, rtol=1e-10, atol=1e-10)
        np.testing.assert_allclose(pick(model, slope, *"xyz"), R @ twist[:3], rtol=0, atol=1e-12)
        turning = oracle.quaternion_rate(quaternion, twist[3:])
        np.testing.assert_allclose(pick(model, slope, *QUATERNION), turning, rtol=0, atol=1e-12)


def test_energy_is_that_of_hull_fluid_and_buoyancy(
    model: Model, samples: tuple[Array, ...]
) -> None:
    vehicle = hull(model)
    _, level = model.energy(model.rest())
    for place, quaternion, twist, _ in zip(*samples, strict=True):
        kinetic, potential = model.energy(state(model, place, quaternion, twist))
        expected = oracle.energy(oracle.rotation_matrix(quaternion), twist, vehicle)
        assert kinetic == pytest.approx(expected[0], rel=1e-11)
        assert potential - level == pytest.approx(expected[1], abs=1e-9)  # [J], of 5000 for m g z


@pytest.mark.parametrize(
    ("parameters", "inputs"),
    # The large hull backs up too: u |u| has a kink there, which costs DOP853 its last digits.
    [(SMOOTH, idle), (COINCIDENT, idle), (VISCOUS, helm), (OTHER | {"d_uu": 0.0}, helm)],
)
def test_twenty_seconds_equal_kirchhoffs(
    model: Model, parameters: dict[str, float], inputs: Inputs
) -> None:
    """Places, attitudes and twists; a difference at the start grows by 30."""
    start, vehicle = tumble(model), hull(model, **parameters)
    path = run(model, start, T, inputs, **parameters)
    place, R = pick(model, start, *"xyz"), attitude(model, start)
    places, attitudes, twists = oracle.simulate(
        place, R, twist_of(model, start), inputs, T, vehicle
    )
    np.testing.assert_allclose(pick(model, path, *"xyz"), places, rtol=0, atol=1e-9)
    found = np.array([attitude(model, x) for x in path])
    np.testing.assert_allclose(found, attitudes, rtol=0, atol=1e-9)
    found = np.array([twist_of(model, x) for x in path])
    np.testing.assert_allclose(found, twists, rtol=0, atol=1e-9)
    assert np.linalg.norm(places[-1] - places[0]) > 1.0


# What is conserved


def invariants(model: Model, path: Array, vehicle: Hull) -> dict[str, Array]:
    """Along a path: energy, momenta and their products, by the oracle's masses."""
    rows = []
    for x in path:
        R, twist = attitude(model, x), twist_of(model, x)
        P, Pi = np.split(vehicle.inertia * twist, 2)
        linear, angular = oracle.impulse(pick(model, x, *"xyz"), R, twist, vehicle)
        energy = sum(oracle.energy(R, twist, vehicle))
        rows.append((energy, P @ P, P @ R[2], R[2] @ R[2], P @ Pi, linear, angular, angular[2]))
    names = ("energy", "PP", "PGamma", "GammaGamma", "PPi", "linear", "angular", "vertical")
    columns = zip(*rows, strict=True)
    return {name: np.array(values) for name, values in zip(names, columns, strict=True)}


def drift(values: Array) -> float:
    """Largest change along a path, relative to the largest value."""
    return float(np.abs(values - values[0]).max() / np.abs(values).max())


def test_bottom_heavy_vehicle_keeps_its_casimirs(model: Model) -> None:
    """|P|^2, P . Gamma, |Gamma|^2 and the energy; gravity also leaves the vertical spin."""
    path = run(model, tumble(model), T, idle, **SMOOTH)
    kept = invariants(model, path, hull(model, **SMOOTH))
    for name in ("energy", "PP", "PGamma", "GammaGamma", "linear", "vertical"):
        assert drift(kept[name]) < 1e-10, name
    for name in ("PPi", "angular"):
        assert drift(kept[name]) > 1e-2, name  # the righting torque is felt


def test_coincident_centres_keep_the_whole_impulse(model: Model) -> None:
    path = run(model, tumble(model), T, idle, **COINCIDENT)
    kept = invariants(model, path, hull(model, **COINCIDENT))
    for name in ("energy", "PP", "PPi", "GammaGamma", "linear", "angular"):
        assert drift(kept[name]) < 1e-10, name
    speeds = [np.linalg.norm(pick(model, x, *RATES[:3])) for x in path]
    assert np.ptp(speeds) > 0.01  # [m/s]; yet the velocity is not conserved


@pytest.mark.parametrize("parameters", [SMOOTH, VISCOUS])
def test_energy_changes_by_work_and_drag(model: Model, parameters: dict[str, float]) -> None:
    vehicle = hull(model, **parameters)

    def slope(t: float, z: Array) -> Array:
        u, twist = helm(t), twist_of(model, z[:-1])
        power = u @ twist[[0, 4, 5]] + oracle.drag(twist, vehicle) @ twist
        return np.append(model.f(z[:-1], u, **parameters), power)

    done = solve_ivp(
        slope, (0, 10), np.append(tumble(model), 0.0), "DOP853", rtol=1e-11, atol=1e-11
    )
    energy = np.array([sum(model.energy(x, **parameters)) for x in done.y[:-1].T])
    work = done.y[-1]
    np.testing.assert_allclose(energy - energy[0], work, rtol=0, atol=1e-8 * np.abs(work).max())
    assert np.abs(work).max() > 10.0  # [J]


def test_attitude_stays_of_unit_length(model: Model) -> None:
    x = tumble(model)
    for k in range(400):
        x = model.step(x, helm(0.05 * k), 0.05)
    assert np.linalg.norm(pick(model, x, *QUATERNION)) == pytest.approx(1.0, abs=1e-6)


# Stability


def eigenvalues(model: Model, x: Array, **parameters: float) -> Array:
    """Of the linearised motion, in [1/s]."""
    return np.linalg.eigvals(model.jacobian(x, np.zeros(3), **parameters)[0])


@pytest.mark.parametrize("speed", [0.3, 1.0, -2.0])
def test_steady_surge_is_unstable_at_munks_rate(model: Model, speed: float) -> None:
    """lambda^2 = m1 (m3 - m1) U^2 / (m3 I2), once in pitch and once in yaw."""
    x = upright(model, x_dot=speed)
    np.testing.assert_allclose(model.f(x, np.zeros(3), **COINCIDENT)[3:], 0.0, atol=1e-12)
    growth = np.sort(eigenvalues(model, x, **COINCIDENT).real)
    expected = oracle.munk_rate(abs(speed), hull(model))
    np.testing.assert_allclose(growth[-2:], expected, rtol=1e-6)
    np.testing.assert_allclose(growth[:2], -expected, rtol=1e-6)
    assert np.abs(growth[2:-2]).max() < 1e-3 * expected  # zeros of multiplicity, cube root of eps


@pytest.mark.parametrize("axis", ["y_dot", "z_dot"])
def test_motion_across_the_hull_is_stable(model: Model, axis: str) -> None:
    """Along the largest added mass; a zero root of multiplicity k is off by eps^(1/k)."""
    roots = eigenvalues(model, upright(model, **{axis: 0.8}), **COINCIDENT)
    frequency = oracle.crossflow_frequency(0.8, hull(model))
    assert np.abs(roots.real).max() < 1e-3 * frequency
    swinging = np.sort(np.abs(roots.imag))[-2:]
    np.testing.assert_allclose(swinging, frequency, rtol=1e-6)


def test_hull_turns_broadside_by_itself(model: Model) -> None:
    """Munk's moment: a small yaw of a moving hull grows until it goes sideways."""
    start = upright(model, x_dot=1.0, R_wz=1e-3)
    path = run(model, start, np.linspace(0, 15, 151), idle, **COINCIDENT)
    across = np.array([abs(twist_of(model, x)[1]) for x in path])
    first, second = across[[20, 30]]
    rate = np.log(second / first)
    assert rate == pytest.approx(oracle.munk_rate(1.0, hull(model)), rel=0.05)
    assert across.max() > 0.4  # [m/s]


# Closed forms


def test_surge_follows_the_closed_form_to_its_terminal_speed(model: Model) -> None:
    """m1 U_dot = F - d_u U - d_uu U^2 from rest."""
    vehicle, t = hull(model), np.linspace(0.0, 30.0, 31)
    path = run(model, model.rest(), t, lambda _: np.array([40.0, 0.0, 0.0]))
    found = pick(model, path, "x_dot")[:, 0]
    np.testing.assert_allclose(found, oracle.surge_run(t, 40.0, vehicle), rtol=0, atol=1e-10)
    top = oracle.terminal_speed(40.0, vehicle)
    steady = model.f(upright(model, x_dot=top), [40.0, 0.0, 0.0])
    np.testing.assert_allclose(pick(model, steady, *RATES), 0.0, atol=1e-12)


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("value", [0.7, -0.4])
def test_each_drag_brakes_its_own_axis(model: Model, rate: str, value: float) -> None:
    """Linear and quadratic, with the model's own coefficients; one axis at a time."""
    vehicle, twist = hull(model), value * (np.array(RATES) == rate)
    slope = pick(model, model.f(upright(model, **{rate: value}), np.zeros(3)), *RATES)
    expected = oracle.accelerations(np.eye(3), twist, np.zeros(3), vehicle)
    np.testing.assert_allclose(slope, expected, rtol=1e-10, atol=1e-12)
    assert slope @ twist < 0


@pytest.mark.parametrize("axis", [0, 1])
def test_small_tilt_rights_itself_at_the_metacentric_frequency(model: Model, axis: int) -> None:
    """sqrt(m g h / I); the fluid adds to pitch and not to roll. The other roots are zero."""
    h = 0.03
    roots = eigenvalues(model, model.rest(), **(SMOOTH | {"h": h}))
    expected = oracle.righting_frequency(axis, hull(model, h=h))
    assert np.abs(roots.imag - expected).min() < 1e-9 * expected
    assert np.abs(roots.real).max() < 1e-3 * expected


@pytest.mark.parametrize("axis", [0, 1])
def test_a_large_tilt_swings_like_a_pendulum(model: Model, axis: int) -> None:
    """Upright after a quarter of the exact period, tilted the other way after a half."""
    amplitude, quarters = 1.2, np.arange(5.0)
    period = oracle.righting_period(axis, amplitude, hull(model))
    tilt = {QUATERNION[axis]: np.sin(amplitude / 2), "R_w": np.cos(amplitude / 2)}
    path = run(model, upright(model, **tilt), quarters * period / 4, idle, **SMOOTH)
    sine = pick(model, path, QUATERNION[axis])[:, 0]
    expected = np.sin(amplitude / 2) * np.array([1.0, 0.0, -1.0, 0.0, 1.0])
    np.testing.assert_allclose(sine, expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(pick(model, path, *"xyz"), 0.0, atol=1e-10)  # it turns in place
