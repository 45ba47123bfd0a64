"""Machines that a page simulates: every registered one, and what else has parts of its own."""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics import Model, System
from kinolab.dynamics.derivation.sampled_states import feasible_values
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from tests import registered
from tests.dynamics.wheeled import roller_racer
from tests.feedback_machines import cart_pole
from tests.machines import four_bar_by_multipliers, rope_pendulum, sprung_cart

Array = NDArray[np.float64]

MAKERS: dict[str, Callable[[], System]] = {
    **registered.MAKERS,
    "cart_pole": cart_pole,  # with a controller that kinolab designs
    "four_bar_by_multipliers": four_bar_by_multipliers,
    "roller_racer": roller_racer,  # with a velocity that is no rate
    "rope_pendulum": rope_pendulum,
    "sprung_cart": sprung_cart,  # with an auxiliary state, a spring and dry friction
}


@cache
def model(name: str) -> Model:
    return MAKERS[name]().model()


@cache
def states(name: str) -> Array:
    """States whose positions the constraints allow, shape (N, nx)."""
    made = model(name)
    samples = feasible_values(SymbolTable.of(made.system))
    speeds = {entry.name: 0.4 for entry in made.quasi_velocities}
    rows = ({**speeds, **values} for values in samples)
    return np.array([[values[entry] for entry in made.state_names] for values in rows])


def inputs(name: str, count: int, share: float = 1.0) -> Array:
    """Random inputs about those that are nearest to nothing, shape (count, nu)."""
    lower, upper = model(name).control_bounds.T
    rng, half = np.random.default_rng(1), share * (upper - lower) / 2
    about = np.clip(0.0, lower + half, upper - half)
    made: Array = about + half * rng.uniform(-1, 1, (count, len(lower)))
    return made
