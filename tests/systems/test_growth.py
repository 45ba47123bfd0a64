"""Where vehicles that cannot slip sideways can get to, by Lie brackets of their own velocities.

A driftless vehicle q_dot = sum of u_i g_i(q) reaches every configuration near q if its fields and
their iterated brackets span all directions (Chow, Rashevskii). The growth vector lists how many
directions brackets of up to 1, 2, ... fields span: dim D_k, D_(k+1) = D_k + [D_1, D_k]. Fields are
what ``Model.velocity`` and ``Model.f`` return; brackets are differences of sixth order.

Sources:
    Murray, Sastry, Nonholonomic motion planning: steering using sinusoids, IEEE Trans. Automatic
        Control 38(5), 1993: growth vectors, the car.
    Laumond, Controllability of a multibody mobile robot, IEEE Trans. Robotics and Automation 9(6),
        1993: a unicycle with any number of trailers.
    Jean, The car with N trailers: characterisation of the singular configurations, ESAIM: Control,
        Optimisation and Calculus of Variations 1, 1996: brackets of N + 2 fields are needed where
        nothing is at right angles, and of F_(N+3), a Fibonacci number, at worst.
    Bullo, Lewis, Kinematic controllability and motion planning for the snakeboard, IEEE Trans.
        Robotics and Automation 19(3), 2003: its two decoupling fields.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations, product
from typing import TypeAlias

import numpy as np
import pytest
from numpy.typing import NDArray

from kinolab import systems
from kinolab.dynamics import (
    Body,
    Model,
    System,
    angle,
    length,
    move,
    rate,
    rot_z,
    velocity,
    zero,
)

Array: TypeAlias = NDArray[np.float64]
Field: TypeAlias = Callable[[Array], Array]  # configurations -> velocities, both of shape (N, n)

# Central differences of sixth order (Fornberg, Mathematics of Computation 51, 1988).
PLACES = np.array([-3, -2, -1, 1, 2, 3])
WEIGHTS = np.array([-1, 9, -45, 45, -9, 1]) / 60
STEP = 0.03  # errs by 1e-8 per bracket; rounding grows by 1 / STEP, to 1e-10 after four of them
NONE, SOME = 1e-6, 1e-3  # a singular value below is 0, one above is not; none lies between


def along(field: Field, q: Array, v: Array) -> Array:
    """Directional derivatives of a field at ``q`` along ``v``, shape (N, n)."""
    spots = q + STEP * PLACES[:, None, None] * v
    values = field(spots.reshape(-1, q.shape[-1])).reshape(spots.shape)
    return np.asarray(np.tensordot(WEIGHTS, values, 1) / STEP)


def bracket(f: Field, g: Field) -> Field:
    """[f, g] = Dg f - Df g."""
    return lambda q: along(g, q, f(q)) - along(f, q, g(q))


def growth(fields: Sequence[Field], q: Array, degree: int) -> tuple[int, ...]:
    """Return dim D_1, ..., dim D_degree at one configuration of shape (n,)."""
    layer, span, dimensions = list(fields), [f(q[None])[0] for f in fields], []
    pairs = list(combinations(fields, 2))  # [f, f] = 0 and [g, f] = -[f, g] add nothing
    for _ in range(degree - 1):
        dimensions.append(rank(span))
        layer = [bracket(f, g) for f, g in pairs]
        span += [f(q[None])[0] for f in layer]
        pairs = list(product(fields, layer))
    return (*dimensions, rank(span))


def rank(vectors: Sequence[Array]) -> int:
    values = np.linalg.svd(np.array(vectors), compute_uv=False)
    assert not ((values > NONE) & (values < SOME)).any(), values
    return int((values > SOME).sum())


def rolling(model: Model, kept: Sequence[str], speed: str, **parameters: float) -> Field:
    """The velocity of some coordinates while one free rate is 1 and the others are 0."""

    def field(q: Array) -> Array:
        x = states(model, kept, q)
        x[:, model.state_names.index(f"{speed}_dot")] = 1.0
        return rates(model, kept, x, **parameters)

    return field


def pushed(model: Model, kept: Sequence[str], push: str, **parameters: float) -> Field:
    """The acceleration of some coordinates from rest under an input of 1.

    From rest all rates grow linearly in time, so that the velocity that belongs to the
    accelerations of the free ones is the acceleration of all.
    """

    def field(q: Array) -> Array:
        x = states(model, kept, q)
        u = np.zeros((len(x), model.nu))
        u[:, model.control_names.index(push)] = 1.0
        free = slice(model.nq, model.nq + len(model.independent))
        x[:, free] = model.f(x, u, **parameters)[:, free]
        return rates(model, kept, x, **parameters)

    return field


def states(model: Model, kept: Sequence[str], q: Array) -> Array:
    """States at rest with these coordinates; the others are 0, shape (N, nx)."""
    x = np.zeros((len(q), model.nx))
    x[:, [model.state_names.index(name) for name in kept]] = q
    return x


def rates(model: Model, kept: Sequence[str], x: Array, **parameters: float) -> Array:
    columns = [model.rate_names.index(f"{name}_dot") for name in kept]
    return np.asarray(model.velocity(x, **parameters)[:, columns])


# Brackets themselves


def test_brackets_of_heisenbergs_fields_are_exact() -> None:
    """g1 = (1, 0, -y / 2), g2 = (0, 1, x / 2): [g1, g2] = (0, 0, 1), all others vanish."""

    def first(q: Array) -> Array:
        return np.stack([1 + 0 * q[:, 0], 0 * q[:, 0], -q[:, 1] / 2], axis=-1)

    def second(q: Array) -> Array:
        return np.stack([0 * q[:, 0], 1 + 0 * q[:, 0], q[:, 0] / 2], axis=-1)

    q = np.array([[0.3, -0.7, 2.0]])
    np.testing.assert_allclose(bracket(first, second)(q), [[0, 0, 1]], rtol=0, atol=1e-12)
    again = bracket(first, bracket(first, second))
    np.testing.assert_allclose(again(q), [[0, 0, 0]], rtol=0, atol=1e-11)


@pytest.mark.parametrize("psi", [0.0, 0.7, -2.0])
def test_brackets_of_the_coin_are_those_of_the_closed_form(psi: float) -> None:
    """g1 = (R cos psi, R sin psi, 0, 1), g2 = d/dpsi; [g2, g1] is rolling sideways without spin."""
    roll, turn = fields(systems.get("rolling_disk", R=0.8).model(), COIN, ("phi", "psi"))
    q = np.array([[0.4, -1.0, psi, 2.0]])
    c, s = 0.8 * np.cos(psi), 0.8 * np.sin(psi)
    np.testing.assert_allclose(roll(q), [[c, s, 0, 1]], rtol=0, atol=1e-12)
    np.testing.assert_allclose(turn(q), [[0, 0, 1, 0]], rtol=0, atol=1e-12)
    aside = bracket(turn, roll)
    np.testing.assert_allclose(aside(q), [[-s, c, 0, 0]], rtol=0, atol=1e-10)
    back = bracket(turn, aside)
    np.testing.assert_allclose(back(q), [[-c, -s, 0, 0]], rtol=0, atol=1e-9)


# Vehicles

COIN = ("x", "y", "psi", "phi")
CAR = ("x", "y", "psi", "delta")
DRIVE = ("x", "y", "psi")
BOARD = ("x", "y", "theta", "psi", "phi")
PLACES_ON_THE_PLANE = [(0.0, 0.0, 0.0), (0.5, -2.0, 0.7), (-1.0, 3.0, np.pi / 2), (0.0, 1.0, -2.5)]


def fields(
    model: Model, kept: Sequence[str], speeds: Sequence[str], **parameters: float
) -> list[Field]:
    return [rolling(model, kept, speed, **parameters) for speed in speeds]


@pytest.fixture(scope="module")
def car() -> Model:
    return systems.get("car", L=1.0, R=1.0).model()


@pytest.fixture(scope="module")
def drive() -> Model:
    return systems.get("diff_drive", r=1.0, b=1.0).model()


@pytest.fixture(scope="module")
def snakeboard() -> Model:
    """A light board, whose brackets are of order 1, without drag."""
    light = {"m": 1.0, "l": 1.0, "J_r": 0.4, "J_w": 0.2, "I_s": 0.0}
    return systems.get("snakeboard", **light, c_r=0.0, c_psi=0.0, c_phi=0.0).model()


@pytest.mark.parametrize("place", PLACES_ON_THE_PLANE)
def test_a_coin_gets_anywhere_with_any_roll(place: tuple[float, ...]) -> None:
    """Murray and Sastry, 1993; the side and the way back complete g1 and g2."""
    coin = systems.get("rolling_disk", R=1.0).model()
    assert growth(fields(coin, COIN, ("phi", "psi")), np.array([*place, 0.3]), 3) == (2, 3, 4)


@pytest.mark.parametrize("place", PLACES_ON_THE_PLANE)
def test_a_differential_drive_gets_to_any_pose(drive: Model, place: tuple[float, ...]) -> None:
    """A unicycle."""
    assert growth(fields(drive, DRIVE, ("phi_l", "phi_r")), np.array(place), 2) == (2, 3)


@pytest.mark.parametrize("place", PLACES_ON_THE_PLANE)
def test_the_wheels_of_a_differential_drive_tell_its_heading(
    drive: Model, place: tuple[float, ...]
) -> None:
    """Of five coordinates only four can be chosen: r (phi_r - phi_l) - b psi stays."""
    five = (*DRIVE, "phi_l", "phi_r")
    q = np.array([*place, 0.4, -0.9])
    assert growth(fields(drive, five, ("phi_l", "phi_r")), q, 4) == (2, 3, 4, 4)


@pytest.mark.parametrize("place", PLACES_ON_THE_PLANE)
@pytest.mark.parametrize("delta", [-0.5, 0.0, 0.3])
def test_a_car_gets_to_any_pose_with_any_steering(
    car: Model, place: tuple[float, ...], delta: float
) -> None:
    """Murray and Sastry, 1993: steer, drive, wriggle, slide."""
    assert growth(fields(car, CAR, ("phi", "delta")), np.array([*place, delta]), 3) == (2, 3, 4)


@pytest.mark.parametrize(
    ("delta", "expected"),
    [(-0.5, (2, 3, 4, 5, 5)), (0.3, (2, 3, 4, 5, 5)), (0.0, (2, 3, 4, 4, 5))],
)
def test_a_car_can_choose_how_far_its_wheels_have_turned(
    car: Model, delta: float, expected: tuple[int, ...]
) -> None:
    """With k = tan(delta) / L, [drive, slide] is k times moving ahead without rolling.

    Straight ahead it takes one more: [wriggle, slide], of brackets of two and of three fields.
    """
    q = np.array([0.2, -0.4, 0.7, delta, 0.5])
    assert growth(fields(car, (*CAR, "phi"), ("phi", "delta")), q, 5) == expected


# Trailers


def tractor(trailers: int) -> System:
    """A unicycle that pulls trailers of length 1, each hitched to the axle before it."""
    x, y, psi, s = length("x"), length("y"), angle("psi"), angle("s")
    hitches = [angle(f"a{n}") for n in range(trailers)]
    axles = [move(x, y) @ rot_z(psi)]
    for hitch in hitches:
        axles.append(axles[-1] @ rot_z(hitch) @ move(-1))
    ahead = zero(velocity(axles[0]).x - rate(s), "the front wheel rolls")
    aside = [zero(velocity(g).y, f"axle {n} does not slip") for n, g in enumerate(axles)]
    bodies = [Body(f"axle {n}", g, mass=1.0, inertia=1.0) for n, g in enumerate(axles)]
    wheel = Body("wheel", axles[0] @ rot_z(s), inertia=1.0)
    return System(
        f"tractor_{trailers}",
        bodies=[*bodies, wheel],
        constraints=[*aside, ahead],
        velocities=[psi, s],
    )


def trailer_growth(angles: Sequence[float], degree: int) -> tuple[int, ...]:
    """Growth vector with these angles between one axle and the next."""
    kept = ("x", "y", "psi", *(f"a{n}" for n in range(len(angles))))
    pulled = fields(tractor(len(angles)).model(), kept, ("psi", "s"))
    return growth(pulled, np.array([0.5, -1.0, 0.7, *angles]), degree)


@pytest.mark.parametrize("angles", [(), (0.0,), (0.8,), (0.0, 0.0), (0.4, -0.9), (0.4, np.pi / 2)])
def test_each_trailer_takes_one_bracket_more(angles: tuple[float, ...]) -> None:
    """2, 3, ..., N + 3 where no trailer is at right angles; the last one may be."""
    expected = tuple(range(2, len(angles) + 4))
    assert trailer_growth(angles, len(expected)) == expected


@pytest.mark.parametrize("turn", [-np.pi / 2, np.pi / 2])
def test_one_trailer_has_no_bad_angle(turn: float) -> None:
    """F_4 = 3 fields suffice."""
    assert trailer_growth((turn,), 3) == (2, 3, 4)


@pytest.mark.parametrize("turn", [-np.pi / 2, np.pi / 2])
@pytest.mark.parametrize("last", [0.0, 0.6])
def test_two_trailers_take_the_fifth_bracket_behind_a_tractor_across(
    turn: float, last: float
) -> None:
    """F_5 = 5: where the first trailer stands still while the tractor drives."""
    assert trailer_growth((turn, last), 5) == (2, 3, 4, 4, 5)


# The snakeboard


@pytest.mark.parametrize("phi", [-0.6, 0.0, 0.3, 0.9])
def test_a_snakeboards_wheels_forbid_no_pose(snakeboard: Model, phi: float) -> None:
    """Its constraints are those of a car; the rotor turns by itself: (2, 3, 4) + (1, 1, 1)."""
    board = fields(snakeboard, BOARD, ("psi", "phi", "s"))
    scaled = [*board[:2], lambda q: 25 * board[2](q)]  # wheels of 4 cm
    assert growth(scaled, np.array([0.4, -0.2, 0.7, 1.1, phi]), 3) == (3, 4, 5)


def test_a_snakeboards_motors_push_along_its_decoupling_fields(snakeboard: Model) -> None:
    """From rest: steering alone, and the rotor against the board about its axles' meeting.

    Along (x, y, theta, psi) the latter is (c cos theta, c sin theta, -(c / l) tan phi, 1) with
    c = J_r / (m l) sin phi cos phi: the momentum equation without momentum (Bullo, Lewis, 2003).
    """
    theta, phi = 0.7, np.array([-0.8, 0.0, 0.4])
    q = np.stack([np.array([0.4, -0.2, theta, 1.1, angle]) for angle in phi])
    steer = pushed(snakeboard, BOARD, "tau_phi")(q)
    np.testing.assert_allclose(steer / steer[:, 4:], np.tile([0, 0, 0, 0, 1], (3, 1)), atol=1e-12)
    rotor = pushed(snakeboard, BOARD, "tau_psi")(q)
    c, ones = 0.4 * np.sin(phi) * np.cos(phi), np.ones(3)
    parts = [c * np.cos(theta), c * np.sin(theta), -c * np.tan(phi), ones, 0 * ones]
    np.testing.assert_allclose(rotor / rotor[:, 3:4], np.stack(parts, axis=-1), atol=1e-12)


@pytest.mark.parametrize(
    ("phi", "expected"),
    [(0.6, (2, 3, 5, 5, 5)), (-0.9, (2, 3, 5, 5, 5)), (0.0, (2, 3, 4, 4, 5))],
)
def test_a_snakeboard_gets_anywhere_from_rest_to_rest(
    snakeboard: Model, phi: float, expected: tuple[int, ...]
) -> None:
    """By motions of one motor at a time. V_1 steers, V_2 = c f - (c / l) tan phi d/dtheta + d/dpsi.

    Ahead is f; a = J_r / (m l). [V_1, V_2] = a (cos 2phi f - (1 / l) sin 2phi d/dtheta), and V_1
    with that turns the pair: four directions. Sideways [V_2, [V_1, V_2]] is (a^2 / l) sin^2 phi,
    which at phi = 0 takes two more derivatives by V_1.
    """
    pushes = [pushed(snakeboard, BOARD, push) for push in ("tau_phi", "tau_psi")]
    scaled = [lambda q, push=push: 0.4 * push(q) for push in pushes]
    assert growth(scaled, np.array([0.4, -0.2, 0.7, 1.1, phi]), 5) == expected
