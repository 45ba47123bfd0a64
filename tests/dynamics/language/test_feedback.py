"""Feedback inside a machine: the law is held over a step, and its gains are python-control's."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

from kinolab.dynamics import (
    Body,
    Feedback,
    Force,
    Model,
    Potential,
    Reference,
    Regulator,
    System,
    dlqr,
    length,
    lqr,
    move,
    parameter,
    rate,
    trim,
    tvlqr,
)
from kinolab.dynamics.analysis.trim import NoTrimError
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.errors import InputError
from kinolab.numerics.riccati import NotStabilisableError
from tests.feedback_machines import MASSES, cart_pole

Array = np.ndarray


@pytest.fixture(scope="module")
def model() -> Model:
    return cart_pole().model()


def upright(states: str = "theta theta_dot x_dot") -> tuple[Array, Array]:
    """Return the textbook's linear cart and pole, for a point mass on a massless pole.

    Source: Ogata, Modern Control Engineering, 5th ed., 2010, example 3-6; theta tips towards +x.
    """
    m, M, l, g = (MASSES[name] for name in ("m", "M", "l", "g"))  # noqa: E741
    A = np.array([[0, 1, 0], [(M + m) * g / (M * l), 0, 0], [-m * g / M, 0, 0]])
    B = np.array([[0], [-1 / (M * l)], [1 / M]])
    assert states == "theta theta_dot x_dot"
    return A, B


def gain_of(model: Model) -> Array:
    """Read the gain off the law, as the change of the input with the state at rest."""
    nudge, at = 1e-4, np.zeros(4)
    order = ["theta", "theta_dot", "x_dot"]
    return -np.array(
        [
            (model.plant_inputs(at + nudge * e, [0.0]) - model.plant_inputs(at - nudge * e, [0.0]))
            / (2 * nudge)
            for e in np.eye(4)[[model.state_names.index(name) for name in order]]
        ]
    ).T


# The law


def test_inputs_of_a_machine_with_feedback_are_its_references(model: Model) -> None:
    assert model.control_names == ("speed",)
    assert model.control_bounds.tolist() == [[-2.0, 2.0]]
    assert model.plant.control_names == ("push",)
    assert model.plant.plant is model.plant
    assert isinstance(model.system.feedback, Feedback)  # designed


def test_the_regulators_gain_is_the_second_engines(model: Model) -> None:
    control = pytest.importorskip("control")
    A, B = upright()
    weights = np.diag([1 / 0.1**2, 1 / 0.5**2, 1 / 0.3**2]), np.array([[1 / 20.0**2]])
    expected, _, _ = control.lqr(A, B, *weights)
    assert np.allclose(gain_of(model), expected, rtol=1e-6)
    assert np.allclose(lqr(A, B, *weights), expected, rtol=1e-9)


def test_a_discrete_gain_is_the_second_engines() -> None:
    control = pytest.importorskip("control")
    A, B = upright()
    step = control.c2d(control.ss(A, B, np.eye(3), 0), 0.02)
    Q, R = np.diag([1.0, 2.0, 3.0]), np.array([[0.5]])
    expected, _, _ = control.dlqr(step.A, step.B, Q, R)
    assert np.allclose(dlqr(step.A, step.B, Q, R), expected, rtol=1e-9)


def test_gains_along_a_motion_settle_on_the_constant_one() -> None:
    control = pytest.importorskip("control")
    A, B = upright()
    step = control.c2d(control.ss(A, B, np.eye(3), 0), 0.02)
    Q, R, count = np.eye(3), np.array([[0.5]]), 1500
    gains = tvlqr(np.tile(step.A, (count, 1, 1)), np.tile(step.B, (count, 1, 1)), Q, R, Q)
    expected, _, _ = control.dlqr(step.A, step.B, Q, R)
    assert np.allclose(gains[0], expected, rtol=1e-9)
    assert not np.allclose(gains[-1], expected, rtol=1e-2)  # nothing comes after the last step


def test_what_no_input_reaches_cannot_be_made_stable() -> None:
    A, B = np.diag([1.0, -1.0]), np.array([[0.0], [1.0]])
    with pytest.raises(NotStabilisableError, match="no stabilising gain"):
        lqr(A, B, np.eye(2), np.eye(1))
    with pytest.raises(NotStabilisableError, match="no stabilising gain"):
        dlqr(A + 1.0 * np.eye(2), B, np.eye(2), np.eye(1))


def test_inputs_are_held_over_a_step_and_cut_at_their_limits(model: Model) -> None:
    x, r, h = np.array([0.3, 0.05, 0.2, -0.1]), np.array([1.0]), 0.05
    held = model.plant_inputs(x, r)

    def slope(_: float, state: Array) -> Array:
        return model.plant.f(state, held)

    run = solve_ivp(slope, (0, h), x, method="DOP853", rtol=1e-12, atol=1e-14)
    assert np.allclose(model.step(x, r, h, substeps=50), run.y[:, -1], atol=1e-11)
    far = np.array([0.0, 0.5, 2.0, 0.0])  # tips forward fast: full force
    assert model.plant_inputs(far, r).tolist() == [20.0]
    assert model.plant_inputs(-far, r).tolist() == [-20.0]
    assert np.array_equal(model.f(far, r), model.plant.f(far, [20.0]))


def test_the_derivative_with_feedback_is_exact(model: Model) -> None:
    x, r, h = np.array([0.3, 0.02, 0.1, -0.1]), np.array([0.1]), 1e-6
    assert abs(model.plant_inputs(x, r)[0]) < 20.0  # within its limits
    in_x, in_r = model.jacobian(x, r)
    numeric = [(model.f(x + h * e, r) - model.f(x - h * e, r)) / (2 * h) for e in np.eye(4)]
    assert np.allclose(in_x, np.transpose(numeric), rtol=1e-7, atol=1e-7)
    assert np.allclose(in_r[:, 0], (model.f(x, r + h) - model.f(x, r - h)) / (2 * h), atol=1e-7)


def test_the_pole_stays_up_and_the_cart_takes_up_its_speed(model: Model) -> None:
    x = np.array([0.0, 0.2, 0.0, 0.0])
    fallen = x.copy()
    for _ in range(1000):
        x = model.step(x, [1.5], 0.02)
    for _ in range(100):
        fallen = model.plant.step(fallen, [0.0], 0.02)
    assert np.allclose(x[1:], [0.0, 1.5, 0.0], atol=1e-6)
    assert abs(fallen[1]) > 1.5


def test_rows_of_references_are_followed_one_by_one(model: Model) -> None:
    x = np.random.default_rng(1).uniform(-0.3, 0.3, (5, 4))
    r = np.linspace(-2, 2, 5)[:, None]
    assert np.array_equal(model.f(x, r), [model.f(a, b) for a, b in zip(x, r, strict=True)])
    assert np.array_equal(model.plant_inputs(x, r)[3], model.plant_inputs(x[3], r[3]))


def test_a_machine_with_feedback_survives_its_file(model: Model) -> None:
    text = machine_to_json(model.system)
    again = Model(machine_from_json(text))
    x, r = np.array([0.3, 0.05, 0.2, -0.1]), np.array([1.0])
    assert np.array_equal(again.plant_inputs(x, r), model.plant_inputs(x, r))
    assert machine_to_json(again.system) == text
    stated = machine_from_json(machine_to_json(cart_pole()))  # before it was designed
    assert isinstance(stated.feedback, Regulator)
    assert np.array_equal(System.of(stated).model().plant_inputs(x, r), model.plant_inputs(x, r))


def test_a_model_is_not_made_of_a_regulator_without_gains() -> None:
    with pytest.raises(InputError, match=r"its gains are still to be found. Take system.model\(\)"):
        Model(cart_pole())


def test_other_parameters_give_other_gains() -> None:
    control = pytest.importorskip("control")
    heavy = cart_pole().with_parameters(m=1.0).model()
    A, B = upright()
    m, M, g = 1.0, MASSES["M"], MASSES["g"]
    A[1, 0], A[2, 0] = (M + m) * g / (M * MASSES["l"]), -m * g / M
    weights = np.diag([1 / 0.1**2, 1 / 0.5**2, 1 / 0.3**2]), np.array([[1 / 20.0**2]])
    assert np.allclose(gain_of(heavy), control.lqr(A, B, *weights)[0], rtol=1e-6)


# Equilibria


def mass_on_cubic_spring() -> tuple[System, Reference]:
    """A mass that a force holds anywhere: u = x + x^3."""
    x = length("x", speed=1.0)
    k = parameter("k", 1.0, "N/m")
    body = Body("mass", move(x), mass=1.0)
    place = Reference("place", limit=1.0, unit="m")
    law = Regulator(
        [place],
        tracked={x: 0.1, rate(x): 0.1},
        about={x: place.symbol},
        schedule={"place": 4},
    )
    spring = Potential(k * x**2 / 2 + k * x**4 / 4)
    force = Force("u", on=body, along=move().x, limit=3.0)
    return System("spring", bodies=[body], efforts=[spring], inputs=[force], feedback=law), place


def test_scheduled_inputs_go_through_every_equilibrium() -> None:
    """u0(r) = r + r^3 is a polynomial of the schedule's degree, so it is met everywhere."""
    system, _ = mass_on_cubic_spring()
    model = system.model()
    for r in np.linspace(-1, 1, 9):
        assert model.plant_inputs([r, 0.0], [r])[0] == pytest.approx(r + r**3, abs=1e-7)


def test_an_equilibrium_is_found_where_it_is() -> None:
    system, _ = mass_on_cubic_spring()
    plant = system.model().plant
    (x,) = plant.system.coordinates
    found = trim(plant, [x, rate(x)], [(x, 0.7)])
    assert found.x == pytest.approx([0.7, 0.0], abs=1e-12)
    assert found.u == pytest.approx([0.7 + 0.7**3], abs=1e-9)


def test_an_equilibrium_that_does_not_exist_is_not_found() -> None:
    plant = cart_pole(feedback=False).model()
    x, theta = plant.system.coordinates
    with pytest.raises(NoTrimError, match=r"cart_pole.*no equilibrium"):
        trim(plant, [theta, rate(theta), rate(x)], [(theta, 0.2)])  # it would speed up for ever


# Mistakes


def wrong(change: Callable[[Regulator], Regulator | Feedback]) -> str:
    system = cart_pole()
    assert isinstance(system.feedback, Regulator)
    with pytest.raises(InputError) as caught:
        system.with_feedback(change(system.feedback)).model()
    return str(caught.value)


def test_mistakes_in_a_regulator_are_named_all_at_once() -> None:
    def change(old: Regulator) -> Regulator:
        theta = old.tracked[0][0]
        return Regulator(
            [Reference("speed", limit=-1.0)],
            tracked={theta: -0.1},
            about={rate(theta): 0.0},
            efforts={"pusch": 1.0},
            schedule={"spede": 2, "speed": 99},
        )

    text = wrong(change)
    for part in (
        "reference 'speed': its limit is -1.0",
        "theta_dot has a value in equilibrium but is not tracked",
        "pusch",
        "Known: push",
        "spede",
        "what counts as large for theta is -0.1",
        "the degree in speed is 99",
    ):
        assert part in text, (part, text)


def test_a_law_gives_every_input_once() -> None:
    speed = Reference("speed", limit=1.0)
    text = wrong(lambda _: Feedback([speed], {"pull": 2 * speed.symbol}))
    assert "its law gives push 0 times" in text
    assert "pull" in text


def test_a_law_has_symbols_of_the_machine_only() -> None:
    speed = Reference("speed", limit=1.0)
    stray = sympy.Symbol("stray")
    assert "stray is not declared" in wrong(lambda _: Feedback([speed], {"push": stray}))
    other = Reference("other", limit=1.0).symbol
    assert "other belongs to" in wrong(lambda _: Feedback([speed], {"push": other}))


def test_what_is_tracked_must_decide_its_own_rates() -> None:
    def change(old: Regulator) -> Regulator:
        _, (turn, large), (speed, slow) = old.tracked  # without the lean, which gravity acts on
        return Regulator(old.references, tracked={turn: large, speed: slow}, about=old.about)

    assert "rests on what is not tracked" in wrong(change)


def test_a_damaged_controller_is_refused() -> None:
    tree = json.loads(machine_to_json(cart_pole()))
    tree["feedback"]["tracked"] = "everything"
    with pytest.raises(InputError, match=r"feedback Regulator tracked: it is 'everything'\."):
        machine_from_json(json.dumps(tree))
