"""Momenta of a machine that floats freely, as a whole: which of them no input changes."""

from __future__ import annotations

import numpy as np

from kinolab.dynamics import Coordinate, Model, System
from kinolab.dynamics.derivation.derivation import is_kinematic
from kinolab.numerics.arrays import Array

RANDOM_STATES = 8
FD_STEP = 1e-5  # of the time in which a state changes by its scale
TOLERANCE = 1e-7  # relative, of derivatives by finite differences
ALONG = ("x", "y", "z")


def momenta_of(system: System) -> tuple[str, ...]:
    """Return which momenta of a machine with an attitude stay constant under all inputs, in words.

    Of all bodies together: the linear momentum along the world's axes, and the angular momentum
    about the centre of mass. They are followed along motions from random states. Machines with
    constraints or without masses are left out, and those in a fluid, which has momentum, too.

    Source: Goldstein, Classical Mechanics, 2nd ed., section 1-2.
    """
    model = system.model().plant
    attached = all(isinstance(c, Coordinate) for c in system.coordinates) or system.constraints
    fluid = any(body.added_mass for body in system.bodies)
    if attached or fluid or system.states or is_kinematic(model.system):
        return ()
    generator = np.random.default_rng(0)
    lower, upper = np.clip(model.control_bounds.T, -1e3, 1e3)
    largest, sizes = np.zeros((2, 3)), np.full((2, 1), 1e-300)
    for _ in range(RANDOM_STATES):
        x = model.rest() + model.state_scales * generator.uniform(-1.0, 1.0, model.nx)
        for part in model.space.spheres:
            x[part.own] /= np.linalg.norm(x[part.own])
        rate = model.f(x, generator.uniform(lower, upper))
        step = FD_STEP / max(1.0, float(np.abs(rate / model.state_scales).max()))
        ahead, behind = (_momenta(system, model, x + s * rate) for s in (step, -step))
        changes = (ahead - behind) / (2.0 * step)
        largest = np.maximum(largest, np.abs(changes.sum(axis=1)))
        sizes = np.maximum(sizes, np.abs(changes).sum(axis=(1, 2))[:, None])
    kept = largest <= TOLERANCE * sizes
    names = "its linear momentum", "its angular momentum about its centre of mass"
    return tuple(_named(name, rows) for name, rows in zip(names, kept, strict=True) if rows.any())


def _named(name: str, kept: Array) -> str:
    axes = [axis for axis, one in zip(ALONG, kept, strict=True) if one]
    return name if len(axes) == 3 else f"{name} along {' and '.join(axes)}"


def _momenta(system: System, model: Model, x: Array) -> Array:
    """Return the linear and the angular momentum of each body at a state, shape (2, bodies, 3)."""
    q_dot = np.where(np.arange(model.nx) < model.nq, model.f(x), 0.0)
    poses = model.frames(x).reshape(-1, 3, 4)
    rates = (model.frames_jacobian(x) @ q_dot).reshape(-1, 3, 4)
    located = [k for k, body in enumerate(system.bodies) if body.located]
    masses = np.array([system.number(system.bodies[k].mass) for k in located])
    places, linear = poses[located, :, 3], masses[:, None] * rates[located, :, 3]
    centre = masses @ places / max(float(masses.sum()), 1e-300)
    angular = np.cross(places - centre, linear)
    for row, k in enumerate(located):
        body, turn = system.bodies[k], poses[k, :, :3]
        inertia = np.array([system.number(e) for e in body.inertia_matrix]).reshape(3, 3)
        hat = turn.T @ rates[k, :, :3]
        angular[row] += turn @ inertia @ np.array([hat[2, 1], hat[0, 2], hat[1, 0]])
    return np.stack([linear, angular])
