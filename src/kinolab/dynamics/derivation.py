"""Equations of motion on a tape: d/dt(dL/dq_dot) - dL/dq = F + w^T lambda, ready to compile.

The left-hand side is formed by projecting each body's Newton-Euler equations onto the directions
of motion (d'Alembert's principle), which gives the same equations as differentiating L without
differentiating any energy. With constraints w(q) q_dot = 0 the directions are those the
constraints allow, q_dot = S(q) v, so that the multipliers drop out.

Source: Bloch, Nonholonomic Mechanics and Control, 2003, chapter 5; Featherstone, Rigid Body
Dynamics Algorithms, 2008, chapters 3 and 5.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from kinolab.dynamics.bodies import Body
from kinolab.dynamics.efforts import Force, Input, Torque
from kinolab.dynamics.frames import Frame
from kinolab.dynamics.kinematics import (
    FrameState,
    Kinematics,
    Motions,
    Twist,
    Vector,
    add,
    cross,
    scale,
)
from kinolab.dynamics.linear import Guards, solve_definite, solve_square
from kinolab.dynamics.lowering import Lowering
from kinolab.dynamics.reach import reach
from kinolab.dynamics.symbols import Coordinate, rate
from kinolab.dynamics.system import System
from kinolab.dynamics.tape import Node, Tape
from kinolab.errors import InputError, Mistake

SAMPLES = 12  # states at which the choice of velocities is judged; more never changed a choice
SMALLEST_PIVOT = 1e-6  # smallest singular value ratio at which a choice of velocities is usable


@dataclass(frozen=True)
class Derivation:
    """Everything that is compiled, as nodes of one tape.

    Attributes:
        independent: Indices of the coordinates whose rates are states.
        state, inputs, parameters: The variable nodes, in the order of the compiled arguments.
        derivative: Of the state, length nx.
        rates: q_dot in full coordinates, length nt.
        frames: Rows of [R | p], 12 per body.
        point_speeds: One bound per body on the speed of its points, in [m/s].
        energy: Kinetic and potential, in [J].
        mass_matrix: In full coordinates, row by row, nt * nt.
        constraint_residual: w(q) q_dot, one per constraint.
        guards: Each must be positive for the derivative to be valid.
    """

    tape: Tape
    independent: tuple[int, ...]
    state: tuple[Node, ...]
    inputs: tuple[Node, ...]
    parameters: tuple[Node, ...]
    derivative: tuple[Node, ...]
    rates: tuple[Node, ...]
    frames: tuple[Node, ...]
    point_speeds: tuple[Node, ...]
    energy: tuple[Node, Node]
    mass_matrix: tuple[Node, ...]
    constraint_residual: tuple[Node, ...]
    guards: tuple[Node, ...]


@dataclass(frozen=True)
class _Symbols:
    """A machine's symbols on a tape, and the translator that knows them."""

    tape: Tape
    lower: Lowering
    coordinates: list[Node]
    rates: list[Node]
    inputs: list[Node]
    parameters: list[Node]

    @classmethod
    def of(cls, system: System) -> _Symbols:
        tape = Tape()
        coordinates = [tape.variable(c.name) for c in system.coordinates]
        rates = [tape.variable(f"{c.name}_dot") for c in system.coordinates]
        inputs = [tape.variable(entry.name) for entry in system.inputs]
        parameters = [tape.variable(p.name) for p in system.parameters]
        bound = dict(zip(system.coordinates, coordinates, strict=True))
        bound |= dict(zip(map(rate, system.coordinates), rates, strict=True))
        bound |= dict(zip((i.symbol for i in system.inputs), inputs, strict=True))
        bound |= dict(zip(system.parameters, parameters, strict=True))
        return cls(tape, Lowering(tape, bound), coordinates, rates, inputs, parameters)


@dataclass(frozen=True)
class _Chart:
    """How all rates follow from the independent ones: q_dot = S v, q_ddot = S v_dot + gamma."""

    independent: tuple[int, ...]
    directions: list[list[Node]]  # columns of S, each of length nt
    rates: list[Node]
    accelerations: list[Node]  # gamma


def derive(system: System) -> Derivation:
    """Derive a machine's equations of motion.

    Raises:
        InputError: If a constraint is not linear in the rates, repeats others or never bites, or
            if a direction of motion has no mass.
    """
    symbols = _Symbols.of(system)
    tape, guards = symbols.tape, Guards()
    chart = _chart(system, symbols, guards)
    reduced = _kinematics(system, symbols, chart)
    count = len(chart.independent)
    M = _mass_matrix(system, symbols, reduced, count)
    _check_masses(system, symbols, M, chart.independent)
    balance = _balance(system, symbols, reduced, count)
    (accelerations,) = solve_definite(tape, M, [balance], guards)
    velocities = [symbols.rates[i] for i in chart.independent]
    full = _kinematics(system, symbols, _unconstrained(symbols))
    size = len(symbols.coordinates)
    states = [reduced(body.frame) for body in system.bodies]
    return Derivation(
        tape=tape,
        independent=chart.independent,
        state=(*symbols.coordinates, *velocities),
        inputs=tuple(symbols.inputs),
        parameters=tuple(symbols.parameters),
        derivative=(*chart.rates, *accelerations),
        rates=tuple(chart.rates),
        frames=tuple(node for state in states for node in _pose(state)),
        point_speeds=tuple(
            _point_speed(symbols, body, state)
            for body, state in zip(system.bodies, states, strict=True)
        ),
        energy=_energy(system, symbols, states),
        mass_matrix=tuple(n for row in _mass_matrix(system, symbols, full, size) for n in row),
        constraint_residual=_residual(system, symbols, chart),
        guards=tuple(guards.nodes),
    )


def _unconstrained(symbols: _Symbols) -> _Chart:
    size = len(symbols.coordinates)
    zero, one = symbols.tape.zero, symbols.tape.one
    directions = [[one if i == j else zero for i in range(size)] for j in range(size)]
    return _Chart(tuple(range(size)), directions, list(symbols.rates), [zero] * size)


def _kinematics(system: System, symbols: _Symbols, chart: _Chart) -> Kinematics:
    tape = symbols.tape
    base: Vector = (tape.zero,) * 3
    if system.gravity:
        strength = symbols.lower(system.gravity.strength)
        x, y, z = (tape.mul(tape.constant(-d), strength) for d in system.gravity.down)
        base = (x, y, z)
    motions = Motions(
        coordinates=symbols.coordinates,
        symbols=symbols.rates,
        rates=chart.rates,
        accelerations=chart.accelerations,
        directions=chart.directions,
        base=base,
    )
    return Kinematics(symbols.lower, motions)


def _mass_matrix(
    system: System, symbols: _Symbols, kinematics: Kinematics, size: int
) -> list[list[Node]]:
    """Sum J^T I J over the bodies; symmetric by construction."""
    tape = symbols.tape
    M = [[tape.zero] * size for _ in range(size)]
    for body in system.bodies:
        columns = kinematics(body.frame).columns
        momenta = [_momentum(symbols, body, column) for column in columns]
        for i in range(size):
            for j in range(i + 1):
                M[i][j] = M[j][i] = tape.add(M[i][j], _power(tape, momenta[i], columns[j]))
    return M


def _balance(system: System, symbols: _Symbols, kinematics: Kinematics, size: int) -> list[Node]:
    """Return what accelerates each direction: inputs less inertia and gravity forces."""
    tape = symbols.tape
    balance = [tape.zero] * size
    for body in system.bodies:
        state = kinematics(body.frame)
        inertial = _inertial_wrench(symbols, body, state)
        for i, column in enumerate(state.columns):
            balance[i] = tape.sub(balance[i], _power(tape, inertial, column))
    for entry, value in zip(system.inputs, symbols.inputs, strict=True):
        for i, share in enumerate(_input_shares(entry, kinematics, size)):
            balance[i] = tape.add(balance[i], tape.mul(value, share))
    return balance


def _momentum(symbols: _Symbols, body: Body, twist: Twist) -> Twist:
    tape, lower = symbols.tape, symbols.lower
    x, y, z = (
        tape.mul(lower(moment), component)
        for moment, component in zip(body.inertia, twist.angular, strict=True)
    )
    return Twist(scale(tape, lower(body.mass), twist.linear), (x, y, z))


def _inertial_wrench(symbols: _Symbols, body: Body, state: FrameState) -> Twist:
    """Newton's m a and Euler's I alpha + omega x I omega, in the body's axes."""
    tape = symbols.tape
    change = _momentum(symbols, body, state.acceleration)
    spin = _momentum(symbols, body, state.velocity).angular
    gyroscopic = cross(tape, state.velocity.angular, spin)
    return Twist(change.linear, add(tape, change.angular, gyroscopic))


def _power(tape: Tape, wrench: Twist, twist: Twist) -> Node:
    linear = tape.dot(wrench.linear, twist.linear)
    return tape.add(linear, tape.dot(wrench.angular, twist.angular))


def _input_shares(entry: Input, kinematics: Kinematics, size: int) -> list[Node]:
    """Return the generalised force of a unit input along each direction of motion."""
    tape = kinematics.tape
    shares = [tape.zero] * size
    for body, sign in ((entry.on, 1), (entry.reacts_on, -1)):
        if body is None:
            continue
        for i, column in enumerate(kinematics(body.frame).columns):
            share = _unit_share(entry, kinematics, body.frame, column)
            shares[i] = (tape.add if sign > 0 else tape.sub)(shares[i], share)
    return shares


def _unit_share(entry: Input, kinematics: Kinematics, frame: Frame, column: Twist) -> Node:
    match entry:
        case Torque():
            axis = kinematics.direction(entry.about, frame)
            return kinematics.tape.dot(axis, column.angular)
        case Force():
            axis = kinematics.direction(entry.along, frame)
            return kinematics.tape.dot(axis, column.linear)


def _pose(state: FrameState) -> Iterable[Node]:
    for row, coordinate in zip(state.rotation, state.position, strict=True):
        yield from (*row, coordinate)


def _point_speed(symbols: _Symbols, body: Body, state: FrameState) -> Node:
    """Bound the speed of the body's points; spin about a shape's axis of symmetry moves none."""
    tape = symbols.tape
    linear = tape.unary("sqrt", tape.dot(state.velocity.linear, state.velocity.linear))
    fastest = tape.zero if body.shapes else linear
    for shape in body.shapes:
        extent = reach(shape)
        spin = [
            component
            for name, component in zip("xyz", state.velocity.angular, strict=True)
            if name not in extent.symmetric_about
        ]
        turning = tape.unary("sqrt", tape.dot(spin, spin)) if spin else tape.zero
        speed = tape.add(linear, tape.mul(turning, symbols.lower(extent.radius)))
        fastest = tape.maximum(fastest, speed)
    return fastest


def _energy(system: System, symbols: _Symbols, states: Sequence[FrameState]) -> tuple[Node, Node]:
    tape = symbols.tape
    kinetic, potential = tape.zero, tape.zero
    for body, state in zip(system.bodies, states, strict=True):
        momentum = _momentum(symbols, body, state.velocity)
        kinetic = tape.add(kinetic, _power(tape, momentum, state.velocity))
        if system.gravity:
            down = tape.dot(map(tape.constant, system.gravity.down), state.position)
            weight = tape.mul(symbols.lower(body.mass), symbols.lower(system.gravity.strength))
            potential = tape.sub(potential, tape.mul(weight, down))
    return tape.mul(tape.constant(0.5), kinetic), potential


def _residual(system: System, symbols: _Symbols, chart: _Chart) -> tuple[Node, ...]:
    velocities = [symbols.lower(constraint.velocity) for constraint in system.constraints]
    actual = dict(zip(symbols.rates, chart.rates, strict=True))
    return tuple(symbols.tape.substitute(velocities, actual))


def _chart(system: System, symbols: _Symbols, guards: Guards) -> _Chart:
    if not system.constraints:
        return _unconstrained(symbols)
    tape = symbols.tape
    w = [_covector(symbols, c.name, symbols.lower(c.velocity)) for c in system.constraints]
    independent = _independent(system, symbols, w)
    dependent = [i for i in range(len(symbols.coordinates)) if i not in independent]
    columns = [[tape.neg(row[i]) for row in w] for i in independent]
    w_dependent = [[row[i] for i in dependent] for row in w]
    shares = solve_square(tape, w_dependent, columns, guards)
    directions = [
        _spread(
            tape, len(symbols.coordinates), {i: tape.one}, dict(zip(dependent, share, strict=True))
        )
        for i, share in zip(independent, shares, strict=True)
    ]
    rates = [
        tape.sum(
            tape.mul(column[k], symbols.rates[i])
            for column, i in zip(directions, independent, strict=True)
        )
        for k in range(len(symbols.coordinates))
    ]
    changes = [_change(symbols, symbols.lower(c.velocity), rates) for c in system.constraints]
    (drift,) = solve_square(tape, w_dependent, [changes], Guards())
    gamma = _spread(tape, len(rates), dict(zip(dependent, drift, strict=True)), {})
    return _Chart(independent, directions, rates, gamma)


def _spread(tape: Tape, size: int, *parts: dict[int, Node]) -> list[Node]:
    """Return a vector that is zero but at the given indices."""
    vector = [tape.zero] * size
    for part in parts:
        for index, node in part.items():
            vector[index] = node
    return vector


def _covector(symbols: _Symbols, name: str, velocity: Node) -> list[Node]:
    """Return the row w(q) of a constraint that must be linear in the rates, and only that."""
    tape = symbols.tape
    row = [tape.derivative([velocity], {r: tape.one})[0] for r in symbols.rates]
    rates = frozenset(symbols.rates)
    nothing = dict.fromkeys(symbols.rates, tape.zero)
    where = f"constraint {name!r}"
    if any(tape.depends_on(entry) & rates for entry in row):
        raise InputError([Mistake(where, "it is not linear in the rates.")])
    if tape.substitute([velocity], nothing)[0] != tape.zero:
        what = "it does not vanish when the machine rests."
        raise InputError([Mistake(where, what, "State a velocity, such as V.y.")])
    if all(entry == tape.zero for entry in row):
        raise InputError([Mistake(where, "it never bites: no rate occurs in it.")])
    return row


def _change(symbols: _Symbols, velocity: Node, rates: Sequence[Node]) -> Node:
    """Return -(d/dt w) q_dot, the part of d/dt (w q_dot) = 0 without second derivatives."""
    tape = symbols.tape
    along = dict(zip(symbols.coordinates, symbols.rates, strict=True))
    (change,) = tape.derivative([velocity], along)
    (actual,) = tape.substitute([change], dict(zip(symbols.rates, rates, strict=True)))
    return tape.neg(actual)


def _independent(system: System, symbols: _Symbols, w: list[list[Node]]) -> tuple[int, ...]:
    """Choose, once, the coordinates whose rates describe the motion.

    The others are those that the constraints determine best at the worst of some sampled states;
    among equals the coordinates that were made first.
    """
    samples = _sampled_rows(system, symbols, w)
    _check_rank(system, samples)
    size, count = len(symbols.coordinates), len(w)
    if system.velocities is not None:
        independent = tuple(system.coordinates.index(c) for c in system.velocities)
        if len(independent) != size - count:
            what = f"{len(independent)} velocities are named; {size - count} are independent."
            raise InputError([Mistake(f"system {system.name!r}", what)])
        candidates = [tuple(i for i in range(size) if i not in independent)]
    else:
        candidates = list(combinations(range(size), count))
    margins = [_margin(samples[:, :, dependent]) for dependent in candidates]
    best = max(range(len(candidates)), key=lambda k: (round(margins[k], 9), -k))
    if margins[best] < SMALLEST_PIVOT:
        what = "no fixed choice of independent velocities works at all sampled states."
        remedy = "Name them with velocities=[…], or check the constraints."
        raise InputError([Mistake(f"system {system.name!r}", what, remedy)])
    independent = tuple(i for i in range(size) if i not in candidates[best])
    return independent


def _sampled_rows(system: System, symbols: _Symbols, w: list[list[Node]]) -> np.ndarray:
    """Evaluate w at random states; shape (samples, constraints, coordinates)."""
    generator = np.random.default_rng(0)
    flat = [entry for row in w for entry in row]
    rows = []
    for _ in range(SAMPLES):
        values = {c.name: _sample(c, generator) for c in system.coordinates}
        values |= system.parameter_values
        rows.append(np.reshape(symbols.tape.evaluate(flat, values), (len(w), -1)))
    return np.array(rows)


def _sample(coordinate: Coordinate, generator: np.random.Generator) -> float:
    if coordinate.topology == "circle":
        return float(generator.uniform(-np.pi, np.pi))
    lower = coordinate.lower if np.isfinite(coordinate.lower) else -coordinate.scale
    upper = coordinate.upper if np.isfinite(coordinate.upper) else lower + 2 * coordinate.scale
    return float(generator.uniform(min(lower, upper - coordinate.scale), upper))


def _check_rank(system: System, samples: np.ndarray) -> None:
    count = samples.shape[1]
    for used in range(1, count + 1):
        ranks = [np.linalg.matrix_rank(rows[:used], tol=1e-9) for rows in samples]
        if max(ranks) < used:
            name = system.constraints[used - 1].name
            what = "it follows from the constraints before it."
            raise InputError([Mistake(f"constraint {name!r}", what, "Leave it out.")])


def _margin(samples: np.ndarray) -> float:
    """Return the worst inverse condition number of square matrices, shape (samples, n, n)."""
    values = np.linalg.svd(samples, compute_uv=False)
    largest = np.maximum(values[:, 0], 1e-300)
    return float(np.min(values[:, -1] / largest))


def _check_masses(
    system: System, symbols: _Symbols, M: list[list[Node]], independent: tuple[int, ...]
) -> None:
    """Name a direction of motion that no mass resists."""
    generator = np.random.default_rng(0)
    values = {c.name: _sample(c, generator) for c in system.coordinates}
    values |= system.parameter_values
    flat = [entry for row in M for entry in row]
    matrix = np.reshape(symbols.tape.evaluate(flat, values), (len(M), len(M)))
    eigenvalues, vectors = np.linalg.eigh(matrix)
    if eigenvalues[0] <= 1e-12 * max(eigenvalues[-1], 1e-300):
        moved = np.flatnonzero(np.abs(vectors[:, 0]) > 0.1)
        names = ", ".join(system.coordinates[independent[i]].name for i in moved)
        what = f"no mass or inertia resists a motion of {names}."
        remedy = "Give a body that it moves a mass or an inertia."
        raise InputError([Mistake(f"system {system.name!r}", what, remedy)])
