"""The second derivation against closed forms, and against the first one where none is known."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from kinolab import systems
from kinolab.dynamics import Model
from kinolab.dynamics.model.second_derivation import SecondDerivation
from tests import feedback_machines, machines, switching_machines
from tests.oracles import rolling_disk

Array = NDArray[np.float64]
AGREEMENT = 1e-9  # of the largest entry: rounding times the condition of the equations
STATES = 6


def states(model: Model) -> tuple[Array, Array]:
    """Return states of the size of their scales, and inputs within their limits."""
    rng = np.random.default_rng(5)
    lower, upper = np.clip(model.state_bounds.T, -1e3, 1e3)
    x = np.clip(rng.normal(size=(STATES, model.nx)) * model.state_scales, lower, upper)
    for first in model.attitudes.values():
        q = rng.normal(size=(STATES, 4))
        x[:, first : first + 4] = q / np.linalg.norm(q, axis=1, keepdims=True)
    return x, rng.uniform(*model.control_bounds.T, size=(STATES, model.nu))


def agrees(model: Model, x: Array, u: Array) -> None:
    first, second = model.f(x, u), SecondDerivation(model).derivative(x, u)
    sizes = np.maximum(np.abs(first).max(axis=1, keepdims=True), model.state_scales)
    assert np.abs((first - second) / sizes).max() < AGREEMENT


def test_a_coin_rolls_as_by_hand() -> None:
    x, u = states(model := systems.get("rolling_disk").model())
    found = SecondDerivation(model).derivative(x, u)
    assert_allclose(
        found[:, -2:], rolling_disk.accelerations(x, u, rolling_disk.Coin()), rtol=1e-12
    )
    speed, psi = 0.25 * x[:, 5], x[:, 2]  # R phi_dot along the heading
    assert_allclose(found[:, 0], speed * np.cos(psi), atol=1e-12)
    assert_allclose(found[:, 1], speed * np.sin(psi), atol=1e-12)


@pytest.mark.parametrize(
    "name",
    ["helicopter", "snakeboard", "motorcycle", "car", "car1_v0", "biped", "submarine"],
)
def test_both_derivations_of_a_machine_agree(name: str) -> None:
    model = systems.get(name).model().plant
    x, u = states(model)
    for mode in range(max(len(model.machine.modes), 1)):
        if model.machine.modes:
            x[:, -1] = mode
        agrees(model, x, u)


@pytest.mark.parametrize("name", sorted(machines.MACHINES))
def test_both_derivations_agree_on_every_word_of_the_vocabulary(name: str) -> None:
    model = machines.MACHINES[name]().model()
    agrees(model, *states(model))


def test_ropes_that_are_taut_and_slack() -> None:
    model = machines.rope_pendulum().model()
    x, u = states(model)
    agrees(model, np.concatenate([x, 0.3 * x, 3.0 * x]), np.concatenate([u, u, u]))


def test_a_machine_with_feedback_is_compared_without_it() -> None:
    model = feedback_machines.cart_pole().model()
    x, u = states(model.plant)
    agrees(model.plant, x, u)
    assert_allclose(
        SecondDerivation(model).derivative(x, u),
        SecondDerivation(model.plant).derivative(x, u),
        rtol=0,
    )


def test_each_mode_has_its_own_equations() -> None:
    model = switching_machines.hopper().model()
    x, u = states(model)
    x[:, -1] = np.arange(STATES) % len(model.machine.modes)
    agrees(model, x, u)


def test_what_was_derived_is_found_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from kinolab.dynamics.lagrange import multiplier_equations

    model = systems.get("pendulum").model()
    x, u = states(model)
    before = SecondDerivation(model).derivative(x, u)
    monkeypatch.delattr(multiplier_equations, "multiplier_form")
    again = systems.get("pendulum").model()  # as another process has it: from disk
    assert again is not model
    assert_allclose(SecondDerivation(again).derivative(x, u), before, rtol=0)
