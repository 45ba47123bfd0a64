"""Energies of a machine as SymPy expressions."""

from __future__ import annotations

import sympy

from kinolab.dynamics.lagrange.printing import written_length
from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.frames import Frame, Rotation, pose, time_derivative, velocity
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import up_in

ZERO = sympy.Integer(0)


def kinetic_energy(system: Mechanism) -> sympy.Expr:
    """Return T in [J]."""
    return sum((_kinetic(body) for body in system.bodies), ZERO)


def energy_length(system: Mechanism, most: float) -> int:
    """Return the symbols, numbers and operations of T written out; any number beyond ``most``.

    Shared subexpressions are built once, so that this is quick where writing is not: the equation
    of a chain's first joint is about as long.
    """
    total = 0
    for body in system.bodies:
        total += written_length(_kinetic(body))
        if total > most:
            break
    return total


def weight_energy(system: Mechanism) -> sympy.Expr:
    """Return the potential energy in uniform gravity in [J]."""
    up = sympy.Matrix(list(up_in(system).values()))
    strength = system.gravity.strength if system.gravity else ZERO
    return sum((body.mass * strength * up.dot(pose(body.frame)[1]) for body in system.bodies), ZERO)


def _kinetic(body: Body) -> sympy.Expr:
    V, carrier = velocity(body.frame), _carrier(body)
    linear, spin = velocity(carrier).linear, _spin(body, carrier)
    energy = body.mass * linear.dot(linear) / 2 + (spin.T * body.inertia_matrix * spin)[0] / 2
    if body.added_mass:
        twist = sympy.Matrix([*V.linear, *V.angular])
        energy += (twist.T * sympy.Matrix(body.added_mass) * twist)[0] / 2
    return energy


def _carrier(body: Body) -> Frame:
    """Return the non-spinning frame of a body of revolution, else the body's own frame.

    The spin angle about the axis of symmetry does not enter the energy, and leaving it out of the
    axes keeps the equations short.
    """
    last = body.frame.motions[-1] if body.frame.motions else None
    if not isinstance(last, Rotation) or any(body.inertia[3:]):
        return body.frame
    across = [i for axis, i in zip("xyz", body.inertia, strict=False) if axis != last.axis]
    if sympy.simplify(across[0] - across[1]) == 0:
        return Frame(body.frame.motions[:-1])
    return body.frame


def _spin(body: Body, carrier: Frame) -> sympy.Matrix:
    """Return a body's angular velocity in the axes of ``_carrier``."""
    spin = velocity(carrier).angular
    for motion in body.frame.motions[len(carrier.motions) :]:
        if isinstance(motion, Rotation):
            spin["xyz".index(motion.axis)] += time_derivative(motion.angle)
    return spin
