"""The equations of motion as a person writes them, by d/dt(dL/dq_dot) - dL/dq = F + w^T lambda.

They are derived here a second time, by SymPy from the energies, and never compiled.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import sympy

from kinolab.dynamics.bodies import Body
from kinolab.dynamics.efforts import Force, Input, Torque
from kinolab.dynamics.frames import (
    Axis,
    Frame,
    Rotation,
    pose,
    rotation_matrix,
    time_derivative,
    velocity,
)
from kinolab.dynamics.printing import one_line
from kinolab.dynamics.symbols import Acceleration, rate
from kinolab.dynamics.system import System

TIDYING = 4.0  # [s] after which no further equation is made more readable
LONGEST = 400  # operations of an expression that SymPy can still simplify in a moment


@dataclass(frozen=True)
class Equations(Sequence[sympy.Eq]):
    """A machine's equations of motion; as a sequence, all of them in order.

    Attributes:
        lagrangian: L = T - V.
        constraints: w(q) q_dot = 0, one per constraint.
        balance: d/dt(dL/dq_dot) - dL/dq = F + w^T lambda, one per coordinate.
        reduced: The same without multipliers, one per independent velocity; empty where there is
            no constraint or where the elimination has no short form.
        velocities: The independent velocities.
    """

    lagrangian: sympy.Expr
    constraints: tuple[sympy.Eq, ...]
    balance: tuple[sympy.Eq, ...]
    reduced: tuple[sympy.Eq, ...]
    velocities: tuple[sympy.Symbol, ...]

    def __len__(self) -> int:
        return len(self.constraints) + len(self.balance)

    def __getitem__(self, index):  # type: ignore[no-untyped-def]
        return (*self.balance, *self.constraints)[index]

    def text(self) -> str:
        """Return everything in plain text with Greek letters and dots."""
        return "\n".join(_text(self))

    def latex(self) -> str:
        """Return everything as LaTeX, one aligned block per group."""
        return "\n".join(_latex(self))

    def _repr_latex_(self) -> str:
        return self.latex()


def equations_of(system: System) -> Equations:
    """Derive a machine's equations of motion from its energies."""
    from kinolab.dynamics.derivation import derive

    deadline = time.monotonic() + TIDYING
    rates = [rate(c) for c in system.coordinates]
    accelerations = [Acceleration(c) for c in system.coordinates]
    lagrangian = _tidy(_kinetic(system) - _potential(system), deadline)
    power = sum((i.symbol * _power(i) for i in system.inputs), sympy.Integer(0))
    multipliers = _multipliers(len(system.constraints))
    w = sympy.Matrix(
        [[sympy.diff(c.velocity, r) for r in rates] for c in system.constraints]
    ).reshape(len(multipliers), len(rates))
    left = [
        _tidy(_euler_lagrange(lagrangian, c, r, rates, accelerations), deadline)
        for c, r in zip(system.coordinates, rates, strict=True)
    ]
    forces = [_tidy(sympy.diff(power, r), deadline) for r in rates]
    held = w.T * sympy.Matrix(multipliers) if multipliers else sympy.zeros(len(rates), 1)
    balance = tuple(
        sympy.Eq(left_side, force + hold, evaluate=False)
        for left_side, force, hold in zip(left, forces, held, strict=True)
    )
    independent = derive(system).independent
    return Equations(
        lagrangian=lagrangian,
        constraints=tuple(
            sympy.Eq(_tidy(c.velocity, deadline), 0, evaluate=False) for c in system.constraints
        ),
        balance=balance,
        reduced=_reduced(system, w, left, forces, independent, deadline),
        velocities=tuple(rates[i] for i in independent),
    )


def _kinetic(system: System) -> sympy.Expr:
    total = sympy.Integer(0)
    for body in system.bodies:
        V = velocity(_carrier(body))
        total += body.mass * V.linear.dot(V.linear) / 2
        spin = velocity(body.frame).angular if _carrier(body) is body.frame else _spin(body)
        total += sum(i * w**2 for i, w in zip(body.inertia, spin, strict=True)) / 2
    return total


def _carrier(body: Body) -> Frame:
    """Return the frame that a body of revolution turns in, else the body's own.

    Its own spin about the axis of symmetry changes no energy, and leaving it out of the axes keeps
    the equations short.
    """
    last = body.frame.motions[-1:] and body.frame.motions[-1]
    if isinstance(last, Rotation):
        others = [i for axis, i in zip("xyz", body.inertia, strict=True) if axis != last.axis]
        if sympy.simplify(others[0] - others[1]) == 0:
            return Frame(body.frame.motions[:-1])
    return body.frame


def _spin(body: Body) -> sympy.Matrix:
    """Return the angular velocity of a body of revolution in its carrier's axes."""
    spin = velocity(_carrier(body)).angular
    for motion in body.frame.motions[-1:]:
        if isinstance(motion, Rotation):
            spin["xyz".index(motion.axis)] += time_derivative(motion.angle)
    return spin


def _potential(system: System) -> sympy.Expr:
    if system.gravity is None:
        return sympy.Integer(0)
    down = sympy.Matrix([sympy.nsimplify(d) for d in system.gravity.down])
    heights = (-body.mass * down.dot(pose(body.frame)[1]) for body in system.bodies)
    return system.gravity.strength * sum(heights, sympy.Integer(0))


def _power(entry: Input) -> sympy.Expr:
    """Return the power of a unit input."""
    total = sympy.Integer(0)
    for body, sign in ((entry.on, 1), (entry.reacts_on, -1)):
        if body is None:
            continue
        V = velocity(body.frame)
        match entry:
            case Torque():
                total += sign * _direction(entry.about, body.frame).dot(V.angular)
            case Force():
                total += sign * _direction(entry.along, body.frame).dot(V.linear)
    return total


def _direction(axis: Axis, frame: Frame) -> sympy.Matrix:
    """Return a frame's axis in the axes of another, the common beginning left out."""
    own, other = list(axis.frame.motions), list(frame.motions)
    while own and other and own[0] == other[0]:
        own, other = own[1:], other[1:]
    vector = sympy.Matrix([1 if axis.name == name else 0 for name in "xyz"])
    for motion in reversed(own):
        if isinstance(motion, Rotation):
            vector = rotation_matrix(motion.axis, motion.angle) * vector
    for motion in other:
        if isinstance(motion, Rotation):
            vector = rotation_matrix(motion.axis, motion.angle).T * vector
    return vector


def _euler_lagrange(
    lagrangian: sympy.Expr,
    coordinate: sympy.Symbol,
    its_rate: sympy.Symbol,
    rates: Sequence[sympy.Symbol],
    accelerations: Sequence[sympy.Symbol],
) -> sympy.Expr:
    momentum = sympy.diff(lagrangian, its_rate)
    change = time_derivative(momentum)
    for r, a in zip(rates, accelerations, strict=True):
        change += sympy.diff(momentum, r) * a
    return change - sympy.diff(lagrangian, coordinate)


def _multipliers(count: int) -> list[sympy.Symbol]:
    return [sympy.Symbol(f"lambda_{i + 1}", real=True) for i in range(count)]


def _reduced(
    system: System,
    w: sympy.Matrix,
    left: Sequence[sympy.Expr],
    forces: Sequence[sympy.Expr],
    independent: tuple[int, ...],
    deadline: float,
) -> tuple[sympy.Eq, ...]:
    """Project the balance onto the motions that the constraints allow, if that stays short."""
    if not system.constraints or len(system.constraints) > 2:
        return ()
    dependent = [i for i in range(len(left)) if i not in independent]
    block = w[:, dependent]
    shares = -(block.adjugate() * w[:, list(independent)]) / sympy.trigsimp(block.det())
    shares = shares.applyfunc(sympy.trigsimp)
    v = sympy.Matrix([rate(system.coordinates[i]) for i in independent])
    v_dot = sympy.Matrix([Acceleration(system.coordinates[i]) for i in independent])
    rates = shares * v
    known = {rate(system.coordinates[i]): rates[k] for k, i in enumerate(dependent)}
    changes = shares * v_dot + shares.applyfunc(time_derivative).subs(known) * v
    known |= {Acceleration(system.coordinates[i]): changes[k] for k, i in enumerate(dependent)}
    equations = []
    for column, i in enumerate(independent):
        side = left[i] + sum(shares[k, column] * left[j] for k, j in enumerate(dependent))
        force = forces[i] + sum(shares[k, column] * forces[j] for k, j in enumerate(dependent))
        side, force = (_tidy(part.subs(known), deadline) for part in (side, force))
        equations.append(sympy.Eq(side, force, evaluate=False))
    return tuple(equations)


def _tidy(expression: sympy.Expr, deadline: float) -> sympy.Expr:
    """Simplify for reading, if there is time left and the result is no longer."""
    best = sympy.expand(expression)
    if time.monotonic() < deadline and best.count_ops() < LONGEST:
        best = sympy.expand(sympy.trigsimp(best))
    return best if best.count_ops() <= 2 * expression.count_ops() else expression


def _text(equations: Equations) -> Iterator[str]:
    yield f"L = {one_line(equations.lagrangian)}"
    for title, group in _groups(equations):
        yield ""
        yield title
        for equation in group:
            yield f"  {one_line(equation.lhs)} = {one_line(equation.rhs)}"


def _latex(equations: Equations) -> Iterator[str]:
    yield rf"$$L = {sympy.latex(equations.lagrangian)}$$"
    for _, group in _groups(equations):
        rows = (rf"{sympy.latex(e.lhs)} &= {sympy.latex(e.rhs)}" for e in group)
        yield "$$\\begin{aligned}" + r" \\ ".join(rows) + "\\end{aligned}$$"


def _groups(equations: Equations) -> Iterator[tuple[str, tuple[sympy.Eq, ...]]]:
    if equations.constraints:
        yield "constraints", equations.constraints
    yield "d/dt(∂L/∂q̇) - ∂L/∂q = F + wᵀλ", equations.balance
    if equations.reduced:
        yield "reduced to the independent velocities", equations.reduced
