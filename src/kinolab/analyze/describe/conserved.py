"""Symmetries: cyclic coordinates, and the momenta that no input changes."""

from __future__ import annotations

import numpy as np

from kinolab.dynamics import Coordinate, Model, System
from kinolab.dynamics.analysis.invariants import change_by, random_states_about_rest, steady
from kinolab.dynamics.derivation.derivation import is_kinematic
from kinolab.dynamics.language.mechanism_parts import imposed_accelerations
from kinolab.numerics.arrays import Array


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
    (kept,) = steady(model, lambda x: (model.mass_matrix(x) * model.velocity(x))[None])
    driven = imposed_accelerations(system)  # whatever is massless has no momentum to keep
    names = (c.name for c, one in zip(system.coordinates, kept, strict=True) if one)
    return tuple(name for name in names if name not in driven)


def momenta_of(system: System) -> tuple[str, ...]:
    """Return which momenta of a machine with an attitude stay constant under all inputs, in words.

    Of all bodies together: the linear momentum along the world's axes, and the angular momentum
    about the centre of mass. Machines with constraints or without masses are left out, and those in
    a fluid, which has momentum, too.

    Source: Goldstein, Classical Mechanics, 2nd ed., section 1-2.
    """
    model = system.model().plant
    attached = all(isinstance(c, Coordinate) for c in system.coordinates) or system.constraints
    fluid = any(body.added_mass for body in system.bodies)
    if attached or fluid or system.states or is_kinematic(model.system):
        return ()
    kept = steady(model, lambda x: _momenta(system, model, x).swapaxes(1, 2))
    names = "its linear momentum", "its angular momentum about its centre of mass"
    return tuple(_named(name, rows) for name, rows in zip(names, kept, strict=True) if rows.any())


def cyclic_coordinates_of(system: System) -> tuple[str, ...]:
    """Return the coordinates on which the Lagrangian does not depend: its symmetries.

    Forces and constraints may depend on them all the same. Machines with attitudes or without
    masses have none that could be named.
    """
    model = system.model().plant
    if is_kinematic(model.system) or not all(isinstance(c, Coordinate) for c in system.coordinates):
        return ()
    states, _ = random_states_about_rest(model)

    def energies(x: Array) -> Array:  # the mass matrix and the potential energy of each state
        kinetic = model.mass_matrix(x).reshape(len(x), -1)
        return np.hstack([kinetic, np.asarray(model.energy(x)[1]).reshape(-1, 1)])

    size = max(float(np.abs(energies(states)).max()), 1e-300)
    # A relative change of an energy by 1e-12 is rounding.
    return tuple(
        c.name
        for k, c in enumerate(system.coordinates)
        # of a coordinate's scale: any other place of it serves as well
        if change_by(energies, states, k, 0.3 * model.state_scales[k]) <= 1e-12 * size
    )


def _named(name: str, kept: Array) -> str:
    axes = [axis for axis, one in zip(("x", "y", "z"), kept, strict=True) if one]
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
        inertia = system.inertia_of(body)
        hat = turn.T @ rates[k, :, :3]
        angular[row] += turn @ inertia @ np.array([hat[2, 1], hat[0, 2], hat[1, 0]])
    return np.stack([linear, angular])
