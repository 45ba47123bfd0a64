"""Energies and nonconservative loads of a machine as SymPy expressions."""

from __future__ import annotations

from collections.abc import Iterator

import sympy

from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.forces import (
    Buoyancy,
    Coulomb,
    Potential,
    Rope,
    SlidingFriction,
    Spring,
    Viscous,
    Wrench,
)
from kinolab.dynamics.language.frames import (
    Axis,
    Frame,
    Rotation,
    Translation,
    distance,
    pose,
    time_derivative,
    turn_matrix,
    velocity,
)
from kinolab.dynamics.language.inputs import Force, Pull, Torque
from kinolab.dynamics.language.mechanism import Mechanism

ZERO = sympy.Integer(0)


def kinetic_energy(system: Mechanism) -> sympy.Expr:
    """Return T in [J]."""
    return sum((_kinetic(body) for body in system.bodies), ZERO)


def potential_energy(system: Mechanism) -> sympy.Expr:
    """Return V in [J]: gravity, springs, buoyancy and other potentials."""
    total = ZERO
    for body in system.bodies:
        total -= body.mass * _gravity(system).dot(pose(body.frame)[1])
    for effort in system.efforts:
        match effort:
            case Potential():
                total += effort.energy
            case Spring():
                total += effort.stiffness * (distance(*effort.between) - effort.length) ** 2 / 2
            case Buoyancy():
                R, p = pose(effort.on.frame)
                place = p + R * sympy.Matrix(effort.at)
                total -= effort.lift * _up(system).dot(place)
    return total


def loads(system: Mechanism) -> Iterator[tuple[sympy.Expr, sympy.Expr]]:
    """Yield (strength, velocity) of every load that is not in the potential energy.

    Ropes are among them: the slope of an energy that is zero on one side reads badly.

    A load's generalised force is the strength times d(velocity)/d(rate).
    """
    yield from velocity_loads(system)
    for rope in ropes(system):
        yield -rope.tension, time_derivative(rope.stretch)
    for strength, reach in pulls(system):
        yield strength, time_derivative(reach)


def ropes(system: Mechanism) -> Iterator[Rope]:
    """Yield the ropes, whose tensions act along what they are stretched."""
    return (effort for effort in system.efforts if isinstance(effort, Rope))


def pulls(system: Mechanism) -> Iterator[tuple[sympy.Expr, sympy.Expr]]:
    """Yield (strength, distance) of every input that pulls along a distance."""
    for entry in system.inputs:
        if isinstance(entry, Pull):
            yield -entry.symbol, distance(*entry.between)


def velocity_loads(system: Mechanism) -> Iterator[tuple[sympy.Expr, sympy.Expr]]:
    """Yield (strength, velocity) of every load that is not along a distance."""
    for effort in system.efforts:
        match effort:
            case Viscous() | Coulomb() | SlidingFriction():
                yield from _friction(effort)
            case Wrench():
                yield from _wrench(effort)
    for entry in system.inputs:
        match entry:
            case Torque():
                for body, sign in ((entry.on, 1), (entry.reacts_on, -1)):
                    if body is not None:
                        axis = _direction(entry.about, body.frame)
                        yield sign * entry.symbol, axis.dot(velocity(body.frame).angular)
            case Force():
                axis = _direction(entry.along, entry.on.frame)
                yield entry.symbol, axis.dot(velocity(entry.on.frame).linear)
                if entry.reacts_on is not None:
                    R, p = pose(entry.on.frame)
                    moving = _velocity_at(entry.reacts_on.frame, p)
                    yield -entry.symbol, (R * axis).dot(moving)


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


def _gravity(system: Mechanism) -> sympy.Matrix:
    """Return gravity in world axes, in [m/s^2]."""
    return system.gravity.strength * -_up(system) if system.gravity else sympy.zeros(3, 1)


def _up(system: Mechanism) -> sympy.Matrix:
    down = system.gravity.down if system.gravity else (0.0, 0.0, -1.0)
    return -sympy.Matrix([sympy.nsimplify(component) for component in down])


def _velocity_at(frame: Frame, place: sympy.Matrix) -> sympy.Matrix:
    """Return the world velocity of the frame-fixed point now at a world position."""
    R, p = pose(frame)
    V = velocity(frame)
    return R * V.linear + (R * V.angular).cross(place - p)


def _friction(
    effort: Viscous | Coulomb | SlidingFriction,
) -> Iterator[tuple[sympy.Expr, sympy.Expr]]:
    match effort:
        case Viscous():
            yield -effort.coefficient * effort.velocity, effort.velocity
        case Coulomb():
            slip = sympy.tanh(effort.velocity / effort.smoothing)
            yield -effort.strength * slip, effort.velocity
        case SlidingFriction():
            size = sympy.sqrt(sum(v**2 for v in (*effort.slip, effort.smoothing)))
            for velocity in effort.slip:
                yield -effort.strength * velocity / size, velocity


def _wrench(effort: Wrench) -> Iterator[tuple[sympy.Expr, sympy.Expr]]:
    R, p = pose(effort.on.frame)
    at = sympy.Matrix(effort.at)
    V = velocity(effort.on.frame)
    here = V.linear + V.angular.cross(at)
    yield from zip(effort.force, here, strict=True)
    yield from zip(effort.torque, V.angular, strict=True)
    if effort.reacts_on is not None:
        other = effort.reacts_on.frame
        moving = R.T * _velocity_at(other, p + R * at)
        turning = R.T * pose(other)[0] * velocity(other).angular
        yield from ((-f, v) for f, v in zip(effort.force, moving, strict=True))
        yield from ((-t, w) for t, w in zip(effort.torque, turning, strict=True))


def _direction(axis: Axis, frame: Frame) -> sympy.Matrix:
    """Express a frame's axis in another frame's axes, the common part of both chains left out."""
    own, other = list(axis.frame.motions), list(frame.motions)
    while own and other and own[0] == other[0]:
        own, other = own[1:], other[1:]
    vector = sympy.Matrix([1 if axis.name == name else 0 for name in "xyz"])
    for motion in reversed(own):
        if not isinstance(motion, Translation):
            vector = turn_matrix(motion) * vector
    for motion in other:
        if not isinstance(motion, Translation):
            vector = turn_matrix(motion).T * vector
    return vector
