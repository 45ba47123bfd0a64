"""Symmetries: cyclic coordinates, and those whose momenta no input changes."""

from __future__ import annotations

import numpy as np

from kinolab.dynamics import Coordinate, Model, System
from kinolab.dynamics.derivation.derivation import is_kinematic
from kinolab.numerics.arrays import Array

RANDOM_STATES = 8
FD_STEP = 1e-5  # relative to a coordinate's magnitude
SAME = 1e-12  # relative change of an energy that is rounding
TOLERANCE = 1e-7  # relative, of derivatives by finite differences


def conserved_momenta(system: System) -> tuple[str, ...]:
    """Return the coordinates whose momenta p = dL/dq_dot stay constant under all inputs.

    Such a coordinate is cyclic, which is a symmetry of the machine, and no force acts along it:
    its row of M v_dot + M_dot v vanishes in every motion (Noether's theorem). Machines with
    constraints are left out, since their forces do not act along single coordinates, and so are
    those with attitudes.

    Source: Goldstein, Classical Mechanics, 2nd ed., section 2-6.
    """
    plain = all(isinstance(c, Coordinate) for c in system.coordinates)
    model = system.model().plant
    held = system.constraints or model.nv < model.nq  # by forces of constraints, or of speeds given
    if held or not plain or system.states or is_kinematic(model.system):
        return ()
    generator = np.random.default_rng(0)
    lower, upper = np.clip(model.control_bounds.T, -1e3, 1e3)
    largest, magnitude = np.zeros(model.nq), 1e-300
    for _ in range(RANDOM_STATES):
        x = model.rest() + model.state_scales * generator.uniform(-1.0, 1.0, model.nx)
        rates, sizes = _momentum_rates(model, x, generator.uniform(lower, upper))
        largest, magnitude = np.maximum(largest, np.abs(rates)), max(magnitude, sizes)
    names = [c.name for c in system.coordinates]
    return tuple(n for n, r in zip(names, largest, strict=True) if r <= TOLERANCE * magnitude)


def cyclic_coordinates_of(system: System) -> tuple[str, ...]:
    """Return the coordinates on which the Lagrangian does not depend: its symmetries.

    Forces and constraints may depend on them all the same. Machines with attitudes or without
    masses have none that could be named.
    """
    model = system.model().plant
    if is_kinematic(model.system) or not all(isinstance(c, Coordinate) for c in system.coordinates):
        return ()
    generator = np.random.default_rng(0)
    changes = np.zeros(model.nq)
    for _ in range(RANDOM_STATES):
        x = model.rest() + model.state_scales * generator.uniform(-1.0, 1.0, model.nx)
        here = _energies(model, x)
        for k in range(model.nq):
            moved = x.copy()
            moved[k] += 0.3 * model.state_scales[k]
            gap = np.abs(_energies(model, moved) - here) / max(float(np.abs(here).max()), 1e-300)
            changes[k] = max(changes[k], float(gap.max()))
    names = [c.name for c in system.coordinates]
    return tuple(n for n, change in zip(names, changes, strict=True) if change <= SAME)


def _energies(model: Model, x: Array) -> Array:
    """Return the mass matrix and the potential energy at a state, in one row."""
    return np.append(model.mass_matrix(x).ravel(), model.energy(x)[1])


def _momentum_rates(model: Model, x: Array, u: Array) -> tuple[Array, float]:
    """Return dp/dt along a motion, shape (nq,), and the magnitude of its terms."""

    def momentum(state: Array) -> Array:
        p: Array = model.mass_matrix(state) @ model.velocity(state)
        return p

    rate = model.f(x, u)
    step = FD_STEP / max(1.0, float(np.abs(rate / model.state_scales).max()))
    rates = (momentum(x + step * rate) - momentum(x - step * rate)) / (2 * step)
    terms = np.abs(model.mass_matrix(x)) @ np.abs(rate[model.nq :])
    return rates, float(max(np.abs(rates).max(), terms.max()))
