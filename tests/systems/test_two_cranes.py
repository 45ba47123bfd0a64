"""Two cranes: closed forms of one crane, and that nothing joins the two."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from kinolab import systems
from kinolab.dynamics import Model

Array = NDArray[np.float64]

G, M = 9.81, 5.0


@pytest.fixture(scope="module")
def model() -> Model:
    return systems.get("two_cranes").model()


def state(model: Model, **values: float) -> Array:
    x = model.rest()
    for name, value in values.items():
        x[model.state_names.index(name)] = value
    return x


def test_the_load_swings_as_a_pendulum_on_an_accelerating_trolley(model: Model) -> None:
    """l s'' = -g sin s - x'' cos s - 2 l' s' - b s'/(m l): Newton in polar coordinates, b = 0.5."""
    generator = np.random.default_rng(0)
    for _ in range(20):
        l, s, ld, sd, xdd, ldd = generator.uniform(0.1, 1.0, 6)  # noqa: E741
        l += 1.0  # noqa: E741
        x = state(model, l_a=l, sway_a=s, l_a_dot=ld, sway_a_dot=sd)
        f = dict(zip(model.state_names, model.f(x, [xdd, ldd, 0, 0]), strict=True))
        expected = (-G * np.sin(s) - xdd * np.cos(s) - 2 * ld * sd - 0.5 * sd / (M * l)) / l
        assert f["sway_a_dot"] == pytest.approx(expected, abs=1e-12)
        assert (f["x_a_dot"], f["l_a_dot"]) == (xdd, ldd)


def test_what_one_crane_does_leaves_the_other_alone(model: Model) -> None:
    still = state(model, sway_b=0.3)
    busy = state(model, sway_b=0.3, sway_a=-0.5, sway_a_dot=1.0, l_a=3.0, x_a_dot=1.0)
    other = [i for i, name in enumerate(model.state_names) if "_b" in name]
    idle, pushed = model.f(still, [0, 0, 0.2, 0.1]), model.f(busy, [1, -1, 0.2, 0.1])
    np.testing.assert_array_equal(idle[other], pushed[other])
    M_full = model.mass_matrix(busy)
    owner = np.array(["_a" in name for name in model.rate_names])
    assert np.abs(M_full[np.ix_(owner, ~owner)]).max() == 0.0


def test_a_rope_carries_the_weight_and_slackens_in_free_fall(model: Model) -> None:
    """At rest the tension is m g; let down with g it is zero; faster, the rope would push."""
    x = model.rest()
    np.testing.assert_allclose(model.requirements(x, [0, 0, 0, 0]), [M * G, M * G], rtol=1e-12)
    np.testing.assert_allclose(model.requirements(x, [0, G, 0, 0])[0], 0.0, atol=1e-12)
    assert model.requirements(x, [0, G + 1, 0, 0])[0] == pytest.approx(-M)


def test_the_cables_run_from_trolley_to_load(model: Model) -> None:
    x = state(model, x_a=2.0, l_a=4.0, sway_a=0.3)
    (top, bottom), _ = model.cables(x)
    np.testing.assert_allclose(top, [2.0, 0.0, 6.0], atol=1e-12)
    swung = [2.0 + 4.0 * np.sin(0.3), 0.0, 6.0 - 4.0 * np.cos(0.3)]
    np.testing.assert_allclose(bottom, swung, atol=1e-12)


def test_sway_is_damped_as_much_as_one_says() -> None:
    """l s'' = -g sin s - c s'/(m l), on a still trolley."""
    system = systems.get("two_cranes", c_s=2.0)
    (damping,) = [entry for entry in system.parameters if entry.name == "c_s"]
    assert (damping.default, damping.unit) == (0.5, "N m s/rad")
    model = system.model()
    x = state(model, l_a=2.0, sway_a=0.3, sway_a_dot=0.7)
    rate = model.f(x, np.zeros(4))[model.state_names.index("sway_a_dot")]
    assert rate == pytest.approx((-G * np.sin(0.3) - 2.0 * 0.7 / (M * 2.0)) / 2.0, abs=1e-12)
