"""The benchmark's machines, derived by kinolab, against the authors' own compiled code."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from kinolab import systems
from kinolab.dynamics import Model
from tests.scenario.dynobench.wheel import MACHINES, ask, environment, needs_wheel

Array = NDArray[np.float64]

STEP = {name: 0.1 if name.startswith(("unicycle", "car")) else 0.01 for name in MACHINES}  # [s]
WORKSPACE = 5.0  # [m]
COUNT = 1000
UNLIMITED = 1e100  # what the benchmark writes for infinity is larger

every_machine = pytest.mark.parametrize("name", MACHINES)
pytestmark = needs_wheel


def states(model: Model, count: int, seed: int) -> Array:
    """Draw states within the limits, attitudes and angles of any size."""
    random = np.random.default_rng(seed)
    lower, upper = model.state_bounds.T.copy()
    for bounds, sign in ((lower, -1.0), (upper, 1.0)):
        bounds[~np.isfinite(bounds)] = sign * WORKSPACE
        bounds[model.circular] = sign * np.pi
    x: Array = random.uniform(lower, upper, (count, model.nx))
    for first in model.attitudes.values():
        q = random.normal(size=(count, 4))
        x[:, first : first + 4] = q / np.linalg.norm(q, axis=1, keepdims=True)
    return x


def wrapped(model: Model, x: Array) -> Array:
    """Return states with their circles in [-pi, pi)."""
    return np.where(model.circular, (x + np.pi) % (2 * np.pi) - np.pi, x)


def apart(model: Model, a: Array, b: Array) -> Array:
    """Return the differences of states, the short way round on circles."""
    return wrapped(model, a - b)


@every_machine
def test_a_step_is_the_benchmarks(name: str) -> None:
    """Rounding alone, 2e-15, lies between what was derived and what was typed in."""
    model = systems.get(name).model()
    x, (lower, upper) = states(model, COUNT, seed=1), model.control_bounds.T
    u = np.random.default_rng(2).uniform(lower, upper, (COUNT, model.nu))
    official = ask("steps", name, environment(MACHINES[name]), x=x, u=u, dt=STEP[name])["x"]
    ours = model.step(x, u, STEP[name], method="euler")
    assert np.abs(apart(model, ours, official)).max() < 1e-9


@every_machine
def test_limits_are_the_benchmarks(name: str) -> None:
    """The workspace limits positions; circles and quaternions have no limits."""
    model = systems.get(name).model()
    official = ask("bounds", name, environment(MACHINES[name]))
    np.testing.assert_array_equal(model.control_bounds.T, [official["u_lb"], official["u_ub"]])
    bounds = np.transpose([official["x_lb"], official["x_ub"]])
    bounds[np.abs(bounds) > UNLIMITED] *= np.inf
    for first in model.attitudes.values():
        bounds[first : first + 4] = -1.0, 1.0
    np.testing.assert_array_equal(model.state_bounds, bounds)
