"""Forces that a machine has already: weights and inertial forces that its author adds by hand.

A generalised force of an effort that equals the weight of a body, or minus the terms of its
equation of motion that are quadratic in the rates, at every state, is that force once more.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np
import sympy

from kinolab.analyze.examine.dampers import slopes_by_rates
from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.dynamics import Body
from kinolab.dynamics.derivation.derivation import is_kinematic
from kinolab.dynamics.language.constraints import PositionConstraint
from kinolab.dynamics.language.forces import Effort
from kinolab.dynamics.language.mechanism_parts import (
    atoms_of,
    energies_in,
    loads_in,
    up_in,
)
from kinolab.dynamics.language.quantities import frames_in, written
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.symbols import InputSymbol, ReferenceSymbol, StateSymbol
from kinolab.numerics.arrays import Array
from kinolab.simulation.stability import random_states

FD_STEP = 1e-5  # of a second, along the rates; the error of central differences is its square
COMPONENTS = ("force", "torque")  # of a wrench, along the axes of its body


def forces_twice(subject: Subject) -> Iterator[Remark]:
    """Yield the efforts that are the weight, or an inertial force, of what the machine moves."""
    system, model = subject.system, subject.model
    efforts = [e for e in system.efforts if not (_driven(e) or is_between_frames(e))]
    if not efforts or is_kinematic(system):
        return
    states = random_states(model)
    q_dots = model.f(states, np.zeros((len(states), model.nu)))[:, : model.nq]
    weights, inertial = _own_forces(subject, states, q_dots)
    for effort in efforts:
        forces = generalised(subject, effort, states, q_dots)
        part = (type(effort).__name__, "")
        for k, name in _same(subject, forces, weights):
            what = f"The {effort} pulls along {name} as the weight of {_whose(subject, k)} does, "
            what += "which gravity=… is already: it is there twice. Take one of them out."
            yield Remark("weight that is there twice", _whose(subject, k), what, part)
            break
        for k, name in _same(subject, forces, inertial):
            what = f"The {effort} is the centrifugal or Coriolis force of {_whose(subject, k)} "
            what += f"along {name}, which follows from its frame: it is there twice. Take the "
            what += "effort out."
            yield Remark("inertial force that is there twice", _whose(subject, k), what, part)
            break


def turned_twice(subject: Subject) -> Iterator[Remark]:
    """Yield the wrenches whose components turn with an angle that turns the body already.

    By an angle that turns the body about the unit vector s, components of a force of the body do
    not change, and those of a force of the world change by -s x F. By + s x F it is turned twice.
    """
    system = subject.system
    values = system.substitutions
    for effort in system.efforts:
        on, stated = getattr(effort, "on", None), [getattr(effort, w, ()) for w in COMPONENTS]
        if on is None or not all(stated):
            continue
        turn = subject.poses(subject.rest)[subject.place_of(on)][:, :3]
        spin = turn.T @ subject.spin(on, subject.rest)
        for c, k in subject.plain.items():
            for components in stated:
                column = sympy.Matrix([exact(entry) for entry in components])
                both = sympy.Matrix.hstack(column, column.diff(c)).subs(values)
                both = both.subs({s: float(subject.rest[i]) for s, i in subject.plain.items()})
                both = both.subs(dict.fromkeys(both.free_symbols, 1.0))
                force, slope = np.array(both, dtype=float).T
                turned = np.cross(spin[:, k], force)
                gap = np.abs(slope - turned).max()
                # 0.05: relative, of the change of components by an angle: of small angles, or of
                # others
                if np.abs(turned).max() > 0 and gap <= 0.05 * np.abs(turned).max():
                    what = f"{c} turns its components, which are along the axes of "
                    what += f"{on.name}: these turn by {c} already, so that it turns twice "
                    what += f"as far. Take the components along the axes of {on.name}."
                    yield Remark("turned twice", str(effort), what, (type(effort).__name__, ""))
                    return


def held_twice(subject: Subject) -> Iterator[Remark]:
    """Yield the constraints that hold what another one holds already, but for a factor."""
    x = subject.moved(dict.fromkeys(subject.plain, 0.1))
    for one, other in combinations(subject.system.constraints, 2):
        if other.name in subject.model.redundant:
            rows = np.array([slopes_by_rates(subject, c.velocity, x) for c in (one, other)])
            if np.linalg.matrix_rank(rows, tol=1e-9 * np.abs(rows).max()) == 1:  # of rounding
                what = f"It holds what {one.name!r} holds already, and was left out: is it another "
                word = "closed" if isinstance(other, PositionConstraint) else "zero"
                what += "one's line, copied and not changed?"
                yield Remark("constraint twice", other.name, what, (word, other.name))


def _driven(effort: Effort) -> bool:
    driven = InputSymbol | StateSymbol | ReferenceSymbol
    return any(isinstance(atom, driven) for atom in atoms_of(effort))


def is_between_frames(effort: Effort) -> bool:
    """Whether it depends on where several frames are, as springs and ropes do, and no weight."""
    sizes = [*energies_in(effort), *(load.magnitude for load in loads_in(effort))]
    return len({frame for size in sizes for frame in frames_in(size)}) > 1


def _whose(subject: Subject, k: int) -> str:
    bodies: tuple[Body, ...] = subject.system.bodies
    return str(bodies[k].name) if k < len(bodies) else "all bodies"


def _same(subject: Subject, forces: Array, own: Array) -> Iterator[tuple[int, str]]:
    """Yield the bodies, or all together, whose forces along a coordinate an effort's equal.

    Args:
        forces: Of the effort, shape (states, coordinates).
        own: Of each body and of all together, shape (bodies + 1, states, coordinates).
    """
    for k, force in enumerate(own):
        for column, coordinate in enumerate(subject.plain):
            size = np.abs(force[:, column]).max()
            gap = np.abs(forces[:, column] - force[:, column]).max()
            # 1e-6, relative: a thousand times that error
            if size > 1e-6 * np.abs(own).max(initial=0.0) and gap <= 1e-6 * size:
                yield k, coordinate.name


def generalised(subject: Subject, effort: Effort, states: Array, q_dots: Array) -> Array:
    """Return the force of an effort along each plain coordinate, shape (states, coordinates)."""
    system, plain = subject.system, list(subject.plain)
    along = [
        sum((written(load.magnitude) * written(load.velocity).diff(c.rates[0])
             for load in loads_in(effort)), sympy.Integer(0))
        - sum((written(energy).diff(c) for energy in energies_in(effort)), sympy.Integer(0))
        for c in plain
    ]  # fmt: skip
    # As arguments: put into long formulas, numbers let SymPy compare for minutes what Max is of.
    values = system.substitutions
    values |= {up: system.number(entry) for up, entry in up_in(system).items()}
    symbols = [*plain, *(c.rates[0] for c in plain), *values]
    if {s for one in along for s in sympy.sympify(one).free_symbols} - set(symbols):
        return np.full((len(states), len(plain)), np.nan)  # it acts on attitudes
    columns = [*subject.plain.values()]
    numbers = np.hstack([states[:, columns], q_dots[:, columns]]).T
    force = sympy.lambdify(symbols, along, "numpy")
    with np.errstate(all="ignore"):
        rows = [np.broadcast_to(one, len(states)) for one in force(*numbers, *values.values())]
    return np.array(rows, dtype=float).T


def _own_forces(subject: Subject, states: Array, q_dots: Array) -> tuple[Array, Array]:
    """Return weights and inertial forces along the plain coordinates.

    Of each body and of all together, shapes (bodies + 1, states, coordinates). An inertial force is
    -J^T (m a, I alpha + w x I w) with the accelerations that are left where all rates are constant.

    Source: Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, 4.3.
    """
    system, columns = subject.system, [*subject.plain.values()]
    gravity = system.gravity
    pull = 0.0 if gravity is None else system.number(gravity.strength)
    down = np.zeros(3) if gravity is None else np.array(system.down, dtype=float)
    shape = (len(system.bodies) + 1, len(states), len(columns))
    weights, inertial = np.zeros(shape), np.zeros(shape)
    for i, (x, q_dot) in enumerate(zip(states, q_dots, strict=True)):
        shift = np.zeros(len(x))
        shift[: len(q_dot)] = FD_STEP * q_dot
        here, ahead, behind = (_jacobians(subject, x + s * shift) for s in (0.0, 1.0, -1.0))
        turns = subject.poses(x)[:, :, :3]
        for k, body in enumerate(system.bodies):
            mass = system.number(body.mass)
            moments = turns[k] @ system.inertia_of(body) @ turns[k].T
            left = (ahead[k] - behind[k]) @ q_dot / (2 * FD_STEP)
            spin = here[k, 3:] @ q_dot
            load = np.append(mass * left[:3], moments @ left[3:] + np.cross(spin, moments @ spin))
            weights[k, i] = (mass * pull * down @ here[k, :3])[columns]
            inertial[k, i] = -(load @ here[k])[columns]
    weights[-1], inertial[-1] = weights[:-1].sum(axis=0), inertial[:-1].sum(axis=0)
    return weights, inertial


def _jacobians(subject: Subject, x: Array) -> Array:
    """Return the velocities and spins of bodies by the rates of entries, (bodies, 6, nq)."""
    slopes = subject.poses_by(x)[:, :, 3]
    spins = [subject.spin(body, x) for body in subject.system.bodies]
    return np.concatenate([slopes, np.array(spins)], axis=1)
