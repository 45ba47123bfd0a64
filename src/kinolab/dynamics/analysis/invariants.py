"""What of a machine stays as it is: where an entry of its state changes, and along its motions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.model.model import Model
from kinolab.numerics.arrays import Array

RANDOM_STATES = 8


def change_by(function: Callable[[Array], Array], states: Array, entry: int, shift: float) -> float:
    """Return the largest change of a function of states (n, nx) where an entry is shifted."""
    shifted = states.copy()
    shifted[:, entry] += shift
    gap: Array = np.abs(function(shifted) - function(states))
    return float(gap.max(initial=0.0))


def random_states_about_rest(model: Model) -> tuple[Array, np.random.Generator]:
    """Return states within a scale of rest, (RANDOM_STATES, nx), and what drew them."""
    generator = np.random.default_rng(0)
    shares = generator.uniform(-1.0, 1.0, (RANDOM_STATES, model.nx))
    states = model.rest() + model.state_scales * shares
    for part in model.space.spheres:
        states[:, part.own] /= np.linalg.norm(states[:, part.own], axis=1, keepdims=True)
    return states, generator


def steady(model: Model, parts: Callable[[Array], Array]) -> NDArray[np.bool_]:
    """Return which sums stay constant in all motions, under all inputs, shape (groups, sums).

    Args:
        model: The machine, without a law.
        parts: Returns the parts of each sum at a state, shape (groups, sums, parts). A change
            counts against those of all parts of its group.
    """
    states, generator = random_states_about_rest(model)
    lower, upper = np.clip(model.control_bounds.T, -1e3, 1e3)
    largest: Array | float = 0.0
    sizes: Array | float = 1e-300
    for x in states:
        rate = model.f(x, generator.uniform(lower, upper))
        # 1e-5 of the time in which a state changes by its scale
        step = 1e-5 / max(1.0, float(np.abs(rate / model.state_scales).max()))
        changes = (parts(x + step * rate) - parts(x - step * rate)) / (2.0 * step)
        largest = np.maximum(largest, np.abs(changes.sum(axis=2)))
        sizes = np.maximum(sizes, np.abs(changes).sum(axis=(1, 2))[:, None])
    # 1e-7, relative, of derivatives by finite differences
    return np.asarray(largest <= 1e-7 * np.asarray(sizes))
