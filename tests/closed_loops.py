"""Closed loops of changed machines, by an integrator that shares nothing with tubes."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from kinolab.verification.tube.proof import Prover
from kinolab.verification.tube.uncertainty import Uncertainty

Array = np.ndarray[Any, np.dtype[np.float64]]


def executed(prover: Prover, uncertainty: Uncertainty, seed: int, *, corner: bool) -> Array:
    """Return the states of one machine within an uncertainty at the rows of a plan, (N+1, nx).

    SciPy's DOP853 to 1e-10, on the compiled equations of motion of a machine with other parameters.

    Args:
        prover: Of the plan.
        uncertainty: What the machine is drawn from.
        seed: Of the draw.
        corner: Whether all that is drawn is at an end of its interval.
    """
    problem, tracker = prover.problem, prover.tracker
    model, generator = (problem.whole or problem.model), np.random.default_rng(seed)

    def drawn(radii: Array) -> Array:
        share = generator.uniform(-1.0, 1.0, len(radii))
        return radii * (np.sign(share) if corner else share)

    names, p = model.parameter_names, model.parameter_vector()
    built = model.with_values(dict(zip(names, p + drawn(uncertainty.radii(problem)), strict=True)))
    x, states = tracker.x[0].copy(), [tracker.x[0].copy()]
    for k, span in enumerate(np.diff(prover.about.nominal.t)):
        seen = x + drawn(uncertainty.measurement_radii(problem))
        u = tracker.limited(tracker.wanted(k, seen)) + drawn(uncertainty.input_radii(problem))
        scale = 1e-12 * problem.scales
        found = solve_ivp(
            lambda _, y, u=u: built.f(y, u), (0.0, span), x, method="DOP853", rtol=1e-10, atol=scale
        )
        x = found.y[:, -1]
        states.append(x)
    return np.array(states)


def outside(tube: Any, states: Array) -> Array:
    """Return by how much states (N+1, nx) are outside a tube, shape (steps + 1, nx)."""
    off = states[: tube.steps + 1] - tube.nominal.x[: tube.steps + 1]
    return np.maximum(off - tube.bounds.high, tube.bounds.low - off)
