"""Human-readable equations of motion, d/dt(dL/dq_dot) - dL/dq = F + w^T lambda, by SymPy.

A second derivation from the energies, which is never compiled. On SO(3) the equations take their
Euler-Poincare form, d/dt(dL/domega) + omega x dL/domega - dL/dR = F + w^T lambda.

Source: Bloch, Nonholonomic Mechanics and Control, 2003, chapters 3 and 5.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import sympy

from kinolab.dynamics.lagrange.energies import energy_length, kinetic_energy, weight_energy
from kinolab.dynamics.lagrange.numbers import number_families, written_alike
from kinolab.dynamics.lagrange.printing import as_latex, one_line, written_length
from kinolab.dynamics.lagrange.simplification import grouped, simplified
from kinolab.dynamics.language.frames import motion_of, time_derivative
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import (
    imposed_accelerations,
    imposed_velocities,
    loads,
    potentials,
    require_one_mode,
    tangent_symbols,
)
from kinolab.dynamics.language.quantities import written
from kinolab.dynamics.language.quasi_velocities import (
    QuasiAcceleration,
    QuasiVelocity,
    QuasiVelocitySymbol,
)
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.symbols import Acceleration, Parameter, TurnAcceleration, TurnRate
from kinolab.errors import LINE_WIDTH, InputError, Mistake

# [s] of CPU time after which no further equation is simplified
SIMPLIFICATION_SECONDS = 4.0
MAX_SIMPLIFIED = 1000  # symbols, numbers and operations of one side worth printing
CONTINUED = "    "  # indentation of a continuation line
MAX_EXPANDED_TERMS = 1_000_000  # intermediate terms of an expansion; a submarine has 65 620


@dataclass(frozen=True)
class Equations(Sequence[sympy.Eq]):
    """A machine's equations of motion; as a sequence, all except the reduced ones.

    Attributes:
        lagrangian: L = T - V; texts leave out its constants, which change no equation.
        balance: d/dt(dL/dq_dot) - dL/dq = F + w^T lambda, one per velocity; of a driven
            coordinate, its imposed acceleration.
        constraints: w(q) q_dot = 0 or h(q) = 0, one per constraint, and velocities that are
            inputs or auxiliary states.
        further: The rates of auxiliary states.
        reduced: The balance without multipliers, one per independent velocity; empty without
            constraints or where the elimination has no short form.
        kinematics: Quasi-velocities and the rates that follow from them; empty where all
            independent velocities are rates.
    """

    lagrangian: sympy.Expr
    balance: tuple[sympy.Eq, ...]
    constraints: tuple[sympy.Eq, ...]
    further: tuple[sympy.Eq, ...]
    reduced: tuple[sympy.Eq, ...]
    kinematics: tuple[sympy.Eq, ...] = ()

    def alike(self) -> Equations:
        """Return the same with numbers written one way, and no constants in the Lagrangian.

        A constant there changes no equation of motion.
        """
        sides = (side for _, group in _groups(self) for e in group for side in e.args)
        families = number_families([self.lagrangian, *sides])

        def written_all(group: tuple[sympy.Eq, ...]) -> tuple[sympy.Eq, ...]:
            return tuple(
                sympy.Eq(*(written_alike(side, families) for side in e.args), evaluate=False)
                for e in group
            )

        moving = self.lagrangian.free_symbols - self.lagrangian.atoms(Parameter)
        _, lagrangian = self.lagrangian.as_independent(*moving, as_Add=True)
        groups = ("balance", "constraints", "further", "reduced", "kinematics")
        written = {name: written_all(getattr(self, name)) for name in groups}
        return replace(self, lagrangian=written_alike(lagrangian, families), **written)

    def __len__(self) -> int:
        return len(self.balance) + len(self.constraints) + len(self.further)

    def __getitem__(self, index):  # type: ignore[no-untyped-def]
        return (*self.balance, *self.constraints, *self.further)[index]

    def text(self) -> str:
        """Return all equations as plain text with Greek letters and dots."""
        return "\n".join(_text(self))

    def latex(self) -> str:
        """Return all equations as LaTeX, one aligned block per group."""
        return "\n".join(f"$${formula}$$" for formula in _latex(self))

    def _repr_latex_(self) -> str:
        """One formula, as notebooks and books want it."""
        rows = r" \\[1.5ex] ".join(_latex(self))
        return rf"$$\begin{{gathered}}{rows}\end{{gathered}}$$"


def equations_of(system: Mechanism) -> Equations:
    """Derive a machine's equations of motion from its energies.

    Raises:
        InputError: If it has modes, cannot be derived, or is too large for anyone to read.
    """
    require_one_mode(system)
    _require_readable(system)
    return _LagrangeDerivation(system).result()


def _require_readable(system: Mechanism) -> None:
    """Refuse what would take minutes or hours, and of which no equation would be printed."""
    # Symbols, numbers and operations of T written out: the arm of seven joints has 17 179 and takes
    # 23 s of CPU time, a chain of twelve 91 212, with equations far longer than are printed.
    if energy_length(system, 30_000) > 30_000:
        where, count = f"system {system.name!r}", len(system.coordinates)
        what = f"its equations of motion, of {count} coordinates, are too long to be read."
        size = "Its kinetic energy alone has more than 30000 symbols and operations."
        remedy = "It can be planned for all the same; plan export writes its equations as C."
        raise InputError([Mistake(where, f"{what} {size}", remedy)])


class _LagrangeDerivation:
    """The steps of one derivation, which share symbols and a time budget."""

    def __init__(self, system: Mechanism) -> None:
        self.system = system
        self.deadline = time.thread_time() + SIMPLIFICATION_SECONDS
        self.velocities = tangent_symbols(system)
        self.accelerations = [acceleration_of(v) for v in self.velocities]
        self.kinematics: tuple[sympy.Eq, ...] = ()
        self.roots: dict[sympy.Expr, sympy.Symbol] = {}  # of velocities, each by a symbol
        self.multipliers = [
            sympy.Symbol(f"lambda_{i + 1}", real=True) for i in range(len(system.constraints))
        ]
        energies = [energy for energy in potentials(system) if not energy.has(sympy.Max)]
        potential = sum((written(energy) for energy in energies), weight_energy(system))
        self.lagrangian = self.brief(kinetic_energy(system) - potential)

    def result(self) -> Equations:
        """Return all equations."""
        constraints = self.system.constraints
        w = sympy.Matrix(
            len(constraints),
            len(self.velocities),
            lambda i, j: self.tidy(sympy.diff(constraints[i].velocity, self.velocities[j])),
        )
        left = [self.tidy(self.left_side(k)) for k in range(len(self.velocities))]
        forces = [self.tidy(force) for force in self.forces()]
        held = w.T * sympy.Matrix(len(constraints), 1, self.multipliers)
        drives = imposed_accelerations(self.system)
        kinematic = self.lagrangian == 0
        balance = (
            []
            if kinematic
            else [
                self.balance(k, left[k], self.with_roots(forces[k] + held[k]), drives)
                for k in range(len(self.velocities))
            ]
        )
        reduced = () if kinematic else self.reduced(w, left, forces, drives)
        return Equations(
            lagrangian=self.lagrangian,
            balance=tuple(balance),
            constraints=(*self.constraint_equations(), *self.rate_equations()),
            further=tuple(
                sympy.Eq(sympy.Symbol(f"{s.name}_dot", real=True), s.derivative, evaluate=False)
                for s in self.system.states
            ),
            reduced=reduced,
            kinematics=self.kinematics if reduced else (),
        )

    def left_side(self, k: int) -> sympy.Expr:
        """Return d/dt(dL/dv) - dL/dq along one velocity, in its Euler-Poincare form on SO(3)."""
        v = self.velocities[k]
        momentum = sympy.diff(self.lagrangian, v)
        change = time_derivative(momentum) + sum(
            sympy.diff(momentum, other) * a
            for other, a in zip(self.velocities, self.accelerations, strict=True)
        )
        if not isinstance(v, TurnRate):
            return change - sympy.diff(self.lagrangian, v.coordinate)
        turns = v.attitude.turn_rate
        spin = sympy.Matrix(turns)
        momenta = sympy.Matrix([sympy.diff(self.lagrangian, turn) for turn in turns])
        return change + spin.cross(momenta)[v.index] - self.slope(v)

    def slope(self, turn: TurnRate) -> sympy.Expr:
        """Return the derivative of the Lagrangian by a rotation about one body axis."""
        alone = {other: 1 if other == turn else 0 for other in turn.attitude.turn_rate}
        return sum(
            (
                sympy.diff(self.lagrangian, entry) * motion_of(entry).subs(alone)
                for entry in turn.attitude.quaternion
            ),
            sympy.Integer(0),
        )

    def forces(self) -> list[sympy.Expr]:
        """Return the generalised nonconservative forces.

        Strengths and velocities are simplified before they are multiplied: the square of a velocity
        along a chain of frames no longer shows its sums of angles.
        """
        total = [sympy.Integer(0)] * len(self.velocities)
        for load in _loads(self.system):
            strength, velocity = (self.joined(self.with_roots_held(part)) for part in load)
            for k, v in enumerate(self.velocities):
                total[k] += strength * sympy.diff(velocity, v)
        return total

    def with_roots_held(self, expression: sympy.Expr) -> sympy.Expr:
        """Return an expression with symbols for the roots in which velocities stand.

        The length of a slip is short as it was written, and long where its squares are expanded.
        """
        for power in sorted(expression.atoms(sympy.Pow), key=str):
            if not power.exp.is_Integer and power.has(*self.velocities):
                self.roots.setdefault(power, sympy.Symbol(f"root_{len(self.roots)}", real=True))
        return expression.xreplace(self.roots)

    def with_roots(
        self, force: sympy.Expr, known: Mapping[sympy.Symbol, sympy.Expr] | None = None
    ) -> sympy.Expr:
        """Return a force in groups, of which each root that was held has one, as it was written.

        Args:
            known: What velocities in the roots are.
        """
        written = {symbol: power.xreplace(known or {}) for power, symbol in self.roots.items()}
        if not written:
            return grouped(force)
        shares = sympy.collect(force, list(written), evaluate=False).items()
        terms = (grouped(share) * written.get(root, root) for root, share in shares)
        return sympy.Add(*terms).xreplace(written)  # of sums that were not collected, too

    def balance(
        self, k: int, left: sympy.Expr, right: sympy.Expr, drives: dict[str, sympy.Symbol]
    ) -> sympy.Eq:
        """Return one equation of motion; a drive imposes the acceleration instead."""
        v = self.velocities[k]
        drive = None if isinstance(v, TurnRate) else drives.get(v.coordinate.name)
        if drive is not None:
            return sympy.Eq(self.accelerations[k], drive, evaluate=False)
        return sympy.Eq(grouped(left), right, evaluate=False)

    def constraint_equations(self) -> Iterator[sympy.Eq]:
        """Yield the constraints as stated by the author."""
        for constraint in self.system.constraints:
            yield sympy.Eq(self.brief(constraint.stated), 0, evaluate=False)

    def rate_equations(self) -> Iterator[sympy.Eq]:
        """Yield the velocities imposed by inputs or auxiliary states."""
        for entry in imposed_velocities(self.system):
            yield sympy.Eq(self.tidy(entry.velocity), entry.symbol, evaluate=False)

    def reduced(
        self,
        w: sympy.Matrix,
        left: Sequence[sympy.Expr],
        forces: Sequence[sympy.Expr],
        drives: dict[str, sympy.Symbol],
    ) -> tuple[sympy.Eq, ...]:
        """Project the balance onto the allowed motions, if the result stays short."""
        from kinolab.dynamics.derivation.derivation import derive

        # 3 constraints, whose elimination stays readable
        if not 0 < w.rows <= 3 or self.system.velocities == "all":
            return ()
        derivation = derive(self.system)
        independent, quasi = derivation.independent, derivation.quasi
        dependent = [i for i in range(len(left)) if i not in independent]
        if len(dependent) != w.rows + len(quasi):
            return ()
        S = self.directions(w, quasi, dependent, independent)
        v = [*(entry.symbol for entry in quasi), *(self.velocities[i] for i in independent)]
        known = self.eliminated(S, v, dependent)
        equations = []
        for column, state in enumerate(v):
            side, force = (
                self.tidy(sum(S[i, column] * part for i, part in enumerate(parts)).xreplace(known))
                for parts in (left, forces)
            )
            force = self.with_roots(force, known)
            equations.append(
                sympy.Eq(grouped(side), force, evaluate=False)
                if column < len(quasi)
                else self.balance(self.velocities.index(state), side, force, drives)
            )
        self.kinematics = tuple(self.kinematic_equations(quasi, dependent, known))
        return tuple(equations) if all(map(self.readable, equations)) else ()

    def directions(
        self,
        w: sympy.Matrix,
        quasi: Sequence[QuasiVelocity],
        dependent: Sequence[int],
        independent: Sequence[int],
    ) -> sympy.Matrix:
        """Return S(q) of q_dot = S v, whose columns are the motions that the constraints allow."""
        defined = sympy.Matrix(
            len(quasi),
            w.cols,
            lambda i, j: self.tidy(sympy.diff(quasi[i].velocity, self.velocities[j])),
        )
        rows, count = sympy.Matrix.vstack(w, defined), len(quasi)
        right = sympy.Matrix.vstack(sympy.zeros(w.rows, count), sympy.eye(count))
        right = right.row_join(-rows[:, list(independent)])
        block = rows[:, list(dependent)]
        shares = (block.adjugate() * right / self.tidy(block.det())).applyfunc(self.tidy)
        S = sympy.zeros(w.cols, right.cols)
        for k, i in enumerate(dependent):
            S[i, :] = shares[k, :]
        for k, i in enumerate(independent, start=count):
            S[i, k] = 1
        return S

    def eliminated(
        self, S: sympy.Matrix, v: Sequence[sympy.Symbol], dependent: Sequence[int]
    ) -> dict[sympy.Symbol, sympy.Expr]:
        """Return dependent velocities and accelerations in terms of the independent ones."""
        states = sympy.Matrix(v)
        changes = sympy.Matrix([acceleration_of(symbol) for symbol in v])
        rates = S * states
        known = {self.velocities[j]: rates[j] for j in dependent}
        changes = S * changes + S.applyfunc(time_derivative).subs(known) * states
        return known | {self.accelerations[j]: changes[j] for j in dependent}

    def kinematic_equations(
        self,
        quasi: Sequence[QuasiVelocity],
        dependent: Sequence[int],
        known: Mapping[sympy.Symbol, sympy.Expr],
    ) -> Iterator[sympy.Eq]:
        """Yield what quasi-velocities are, and the rates that follow from them."""
        for entry in quasi:
            yield sympy.Eq(entry.symbol, self.brief(entry.velocity), evaluate=False)
        for j in dependent if quasi else ():
            rate = self.velocities[j]
            yield sympy.Eq(rate, self.brief(known[rate]), evaluate=False)

    def tidy(self, expression: sympy.Expr) -> sympy.Expr:
        """Simplify within the time budget, if the expression is not too long."""
        expression = exact(expression)
        if _terms(expression) > MAX_EXPANDED_TERMS:
            return expression
        return simplified(expression, self.deadline)

    def joined(self, expression: sympy.Expr) -> sympy.Expr:
        """Simplify where products of sines may join into sines of sums."""
        return self.tidy(expression) if expression.has(sympy.sin, sympy.cos) else expression

    def brief(self, expression: sympy.Expr) -> sympy.Expr:
        """Simplify and collect terms with common factors."""
        return grouped(self.tidy(expression))

    def readable(self, equation: sympy.Eq) -> bool:
        """Whether an equation is short enough to read."""
        return max(map(written_length, equation.args)) <= MAX_SIMPLIFIED


def _loads(system: Mechanism) -> Iterator[tuple[sympy.Expr, sympy.Expr]]:
    """Yield the strength of every force that is not in the Lagrangian, and what it acts along.

    Potentials with a kink are among them, such as those of ropes: the slope of an energy that is
    zero on one side reads badly.
    """
    for _, load in loads(system):
        yield written(load.magnitude), written(load.velocity)
    for energy in potentials(system):
        for share, side in _sides(energy) if energy.has(sympy.Max) else ():
            if side != 0:
                yield -written(share), time_derivative(written(side))


def _sides(energy: sympy.Expr) -> Iterator[tuple[sympy.Expr, sympy.Expr]]:
    """Yield what an energy is on each side of its kinks, where lengths are positive.

    The first of a pair is 1 on that side, 0 on others.
    """
    kink = min(energy.atoms(sympy.Max), key=str, default=None)
    if kink is None:
        yield sympy.Integer(1), sympy.powdenest(energy, force=True)
        return
    for most in kink.args:
        shares = [(1 + sympy.sign(most - other)) / 2 for other in kink.args if other != most]
        for share, side in _sides(energy.xreplace({kink: most})):
            yield sympy.Mul(share, *shares), side


def acceleration_of(velocity: sympy.Symbol) -> sympy.Symbol:
    """Return the symbol of the time derivative of a rate or a quasi-velocity."""
    if isinstance(velocity, TurnRate):
        return TurnAcceleration(velocity)
    if isinstance(velocity, QuasiVelocitySymbol):
        return QuasiAcceleration(velocity)
    return Acceleration(velocity.coordinate)


def _terms(expression: sympy.Expr) -> int:
    """Bound the number of terms of an expression after full expansion."""
    parts = [_terms(part) for part in expression.args]
    if expression.is_Mul:
        return math.prod(parts)
    if expression.is_Pow and expression.exp.is_Integer and expression.exp > 0:
        n = min(int(expression.exp), MAX_EXPANDED_TERMS)
        return math.comb(parts[0] + n - 1, n) if parts[0] <= MAX_EXPANDED_TERMS else parts[0]
    return max(sum(parts), 1)


def _text(equations: Equations) -> Iterator[str]:
    equations = equations.alike()
    if equations.balance:
        yield from _lines("L", equations.lagrangian, "")
    for title, group in _groups(equations):
        yield ""
        yield title
        for equation in group:
            left = _line(equation.lhs)
            yield from _lines(left, equation.rhs, "  ")


def _lines(left: str, right: sympy.Expr, indent: str) -> Iterator[str]:
    """Yield the lines of an equation, broken before signs."""
    line = f"{indent}{left} = {_line(right)}"
    while len(line) > LINE_WIDTH and (place := _break(line, len(indent) + len(CONTINUED))):
        yield line[:place]
        line = f"{indent}{CONTINUED}{line[place + 1 :]}"
    yield line


def _break(line: str, first: int) -> int:
    """Return the best line break: late, in as few brackets as possible; 0 if none."""
    places = [found.start() for found in re.finditer(" [-+=] ", line) if found.start() > first]
    cancelled = [place for place in places if LINE_WIDTH / 2 < place <= LINE_WIDTH]
    depths = {place: line.count("(", 0, place) - line.count(")", 0, place) for place in cancelled}
    if cancelled:
        return max(cancelled, key=lambda place: (-depths[place], place))
    return min(places, key=lambda place: abs(place - LINE_WIDTH), default=0)


def _line(expression: sympy.Expr) -> str:
    length = written_length(expression)
    if length > MAX_SIMPLIFIED:
        return f"(an expression of {length} symbols, numbers and operations)"
    return one_line(expression, short=False)


def _latex(equations: Equations) -> Iterator[str]:
    equations = equations.alike()
    if equations.balance:
        yield f"L = {_formula(equations.lagrangian)}"
    for _, group in _groups(equations):
        rows = (rf"{_formula(e.lhs)} &= {_formula(e.rhs)}" for e in group)
        yield r"\begin{aligned}" + r" \\ ".join(rows) + r"\end{aligned}"


def _formula(expression: sympy.Expr) -> str:
    length = written_length(expression)
    if length > MAX_SIMPLIFIED:
        return rf"\text{{(an expression of {length} symbols, numbers and operations)}}"
    return as_latex(expression, short=False)


def _groups(equations: Equations) -> Iterator[tuple[str, tuple[sympy.Eq, ...]]]:
    groups = (
        ("constraints", equations.constraints),
        ("d/dt(∂L/∂q̇) - ∂L/∂q = F + wᵀλ", equations.balance),
        ("auxiliary states", equations.further),
        ("quasi-velocities", equations.kinematics),
        ("reduced to the independent velocities", equations.reduced),
    )
    yield from ((title, group) for title, group in groups if group)
