"""Equations of motion d/dt(dL/dq_dot) - dL/dq = F + w^T lambda as an expression graph.

The left-hand side is formed by projecting each body's Newton-Euler equations onto directions of
motion (d'Alembert's principle), which is equivalent to differentiating L but differentiates no
energy. There are two forms. The reduced form projects onto the directions that the constraints
allow, nu = S(q) v + U(q) u, so that the multipliers drop out. In the other form all velocities are
states, and the multipliers follow from d/dt(A nu) = 0.

Source: Bloch, Nonholonomic Mechanics and Control, 2003, chapter 5; Featherstone, Rigid Body
Dynamics Algorithms, 2008, chapters 3 and 8.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.kinematics import FrameState, Kinematics
from kinolab.dynamics.derivation.lowering import Lowering
from kinolab.dynamics.derivation.newton_euler import NewtonEuler
from kinolab.dynamics.derivation.sampled_states import feasible_values
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.derivation.symbolic_solve import Guards, solve_definite, solve_square
from kinolab.dynamics.derivation.vectors import Vector
from kinolab.dynamics.derivation.velocity_coordinates import (
    VelocityCoordinates,
    combine,
    constraint_rows,
    unconstrained_coordinates,
    velocity_coordinates,
)
from kinolab.dynamics.language.frames import Frame, Translation
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import (
    atoms_of,
    coordinate_of,
    imposed_velocities,
    require_one_mode,
)
from kinolab.dynamics.language.quasi_velocities import QuasiVelocity
from kinolab.dynamics.language.shapes import Shape
from kinolab.dynamics.language.shapes.bounding_radius import bounding_radius
from kinolab.dynamics.symbols.expressions import is_zero
from kinolab.dynamics.symbols.symbols import ForceSymbol
from kinolab.errors import InputError, Mistake
from kinolab.numerics.manifolds.state_parts import Part, completed, spheres_of

# The same for accelerations, of each row's own compliance: above its rounding, and small beside the
# ratio of masses, the share that a heavy part has in the compliance of a light one.
ROW_REGULARISATION = 1e-12
# refinement steps, after which the regularisation no longer affects the motion (measured)
ITERATIVE_REFINEMENTS = 3


@dataclass(frozen=True)
class Derivation:
    """Everything that is compiled, as nodes of one expression graph.

    Attributes:
        binding: The expression graph and its variables.
        independent: Indices of the velocities that are states.
        quasi: The quasi-velocities that are states, before those.
        redundant: Names of redundant constraints.
        state: The variables of x = (q, v, auxiliary states).
        parts: Of the state: lines, circles and unit spheres.
        derivative: Of the state, length nx.
        velocities: nu in full, length nt.
        flow: q_dot, length nq.
        projection: The state projected onto constraints and unit spheres; may be empty.
        frames: Rows of [R | p], 12 per body.
        spins: Angular velocity of each body in its own axes, 3 per body.
        velocities_of_origins: Of each body, in its own axes, and in those before each of its last
            turns, which do not move its origin.
        seats: Where each body's origin is in the axes of each body, bodies * bodies * 3 in [m]; NaN
            where that is not fixed.
        cables: World positions of both ends of every cable, 6 per cable.
        point_speeds: Upper bound on the speed of each body's points, in [m/s].
        cable_speeds: The same per cable.
        energy: Kinetic and potential, in [J]; empty for a kinematic machine.
        power: Of all nonconservative forces, in [W].
        mass_matrix: In full coordinates, row-major, nt * nt; empty for a kinematic machine.
        constraint_residual: w(q) nu of every constraint, then h(q) of position constraints.
        constraint_forces: The multiplier of every constraint row.
        requirements: Each must be nonnegative in a plan.
        guards: Each must be positive for the derivative to be valid.
        chart_guards: Those of the velocities alone.
        balance: The entries of the state that are velocities with M v_dot = F, and the nodes of M,
            row-major, and of F; all empty where accelerations follow from multipliers.
    """

    binding: SymbolTable
    independent: tuple[int, ...]
    quasi: tuple[QuasiVelocity, ...]
    redundant: tuple[str, ...]
    state: tuple[Node, ...]
    parts: tuple[Part, ...]
    derivative: tuple[Node, ...]
    velocities: tuple[Node, ...]
    flow: tuple[Node, ...]
    projection: tuple[Node, ...]
    frames: tuple[Node, ...]
    spins: tuple[Node, ...]
    velocities_of_origins: tuple[tuple[Vector, ...], ...]
    seats: tuple[Node, ...]
    cables: tuple[Node, ...]
    point_speeds: tuple[Node, ...]
    cable_speeds: tuple[Node, ...]
    energy: tuple[Node, ...]
    power: tuple[Node, ...]
    mass_matrix: tuple[Node, ...]
    constraint_residual: tuple[Node, ...]
    constraint_forces: tuple[Node, ...]
    requirements: tuple[Node, ...]
    guards: tuple[Node, ...]
    chart_guards: tuple[Node, ...]
    balance: tuple[tuple[int, ...], tuple[Node, ...], tuple[Node, ...]]

    @property
    def arguments(self) -> dict[str, tuple[Node, ...]]:
        """What functions of a state take: x, u and p."""
        return {"x": self.state, "u": self.binding.inputs, "p": self.binding.parameters}


def derive(system: Mechanism, *, idle_inputs: bool = False) -> Derivation:
    """Derive a machine's equations of motion.

    Args:
        system: The machine; of one with modes, ``in_mode`` gives what can be derived.
        idle_inputs: Whether inputs may be without effect.

    Raises:
        InputError: If a constraint is not linear in the rates or is vacuous, if an input has no
            effect, if a direction of motion has no mass, or if something divides by zero.
    """
    require_one_mode(system)
    try:
        return _Derivation(system).result(idle_inputs=idle_inputs)
    except ZeroDivisionError as error:
        where = f"system {system.name!r}"
        raise InputError([Mistake(where, f"it is singular everywhere: {error}.")]) from error


def is_kinematic(system: Mechanism) -> bool:
    """Whether inputs or auxiliary states impose velocities and no body has mass or inertia."""
    return bool(imposed_velocities(system)) and all(body.massless for body in system.bodies)


class _Derivation:
    """The steps of one derivation on a shared expression graph."""

    def __init__(self, system: Mechanism) -> None:
        self.system = system
        self.binding = SymbolTable.of(system)
        self.tape = self.binding.tape
        self.guards = Guards()
        self.balance: tuple[tuple[int, ...], tuple[Node, ...], tuple[Node, ...]] = (), (), ()
        self.multipliers = self.binding.by_multipliers
        if self.multipliers and self.binding.imposed:
            what = 'a given velocity needs independent ones; velocities="all" has none.'
            raise InputError([Mistake(f"system {system.name!r}", what)])
        self.chart = velocity_coordinates(self.binding, self.guards)
        self.rows = self.chart.rows
        if not self.chart.states and not self.chart.input_directions:
            what = "nothing in it can move."
            remedy = "Give it coordinates, and fewer constraints than coordinates."
            raise InputError([Mistake(f"system {system.name!r}", what, remedy)])
        self.chart_guards = tuple(self.guards.nodes)
        self.states = self.chart.states

    def result(self, *, idle_inputs: bool) -> Derivation:
        """Return all nodes."""
        binding, chart = self.binding, self.chart
        solve = self._accelerations_by_multipliers if self.multipliers else self._accelerations
        accelerations = solve() if self.states else []
        kinetics = self._along(chart)
        actual = binding.at(chart.velocities)
        changes = [binding.lower(entry.derivative) for entry in self.system.states]
        extras = self.tape.substitute(changes, actual)
        flow = tuple(binding.flow(chart.velocities)[node] for node in binding.configuration)
        nu_dot = combine(binding, chart.directions, accelerations)
        nu_dot = [self.tape.add(a, b) for a, b in zip(nu_dot, chart.accelerations, strict=True)]
        massive, whole = not is_kinematic(self.system), unconstrained_coordinates(binding)
        forces = self._constraint_forces(nu_dot) if self.rows and massive else ()
        poses = [kinetics.kinematics(body.frame) for body in self.system.bodies]
        ends = [tuple(map(kinetics.kinematics, cable.between)) for cable in self.system.cables]
        if not idle_inputs:
            self._check_inputs((*accelerations, *flow, *extras))
        state = (*binding.configuration, *self.states, *binding.states)
        return Derivation(
            binding=binding,
            independent=chart.independent,
            quasi=chart.quasi,
            redundant=chart.redundant,
            state=state,
            parts=completed(self.binding.parts, len(state)),
            derivative=(*flow, *accelerations, *extras),
            velocities=chart.velocities,
            flow=flow,
            projection=self._projection(),
            frames=tuple(
                node
                for pose in poses
                for row, entry in zip(pose.rotation, pose.position, strict=True)
                for node in (*row, entry)
            ),
            spins=tuple(node for pose in poses for node in pose.velocity.angular),
            velocities_of_origins=tuple(
                tuple(
                    kinetics.kinematics(frame).velocity.linear for frame in _at_origin(body.frame)
                )
                for body in self.system.bodies
            ),
            seats=self._seats(kinetics.kinematics, state),
            cables=tuple(node for pair in ends for end in pair for node in end.position),
            point_speeds=tuple(
                _point_speed(binding, self.system.kept_shapes(body), pose)
                for body, pose in zip(self.system.bodies, poses, strict=True)
            ),
            cable_speeds=tuple(  # points move with convex combinations of the ends' velocities
                self.tape.maximum(*(_origin_speed(binding, end) for end in pair)) for pair in ends
            ),
            energy=kinetics.energy() if massive else (),
            power=(self._power(nu_dot),) if massive else (),
            mass_matrix=tuple(entry for row in self._along(whole).mass_matrix() for entry in row)
            if massive
            else (),
            constraint_residual=self._residual(),
            constraint_forces=forces,
            requirements=self._requirements(forces),
            guards=tuple(self.guards.nodes),
            chart_guards=self.chart_guards,
            balance=self.balance,
        )

    def _seats(self, kinematics: Kinematics, state: Sequence[Node]) -> tuple[Node, ...]:
        """Return where origins of bodies are in the axes of bodies, NaN where that changes."""
        tape, frames, found = self.tape, [body.frame for body in self.system.bodies], list[Node]()
        nowhere, moving = (tape.constant(math.nan),) * 3, frozenset(state)
        for frame in frames:
            for carrier in frames:
                at = kinematics.place(frame, carrier)
                fixed = not any(tape.depends_on(node) & moving for node in at)
                found += at if fixed else nowhere
        return tuple(found)

    def _along(self, chart: VelocityCoordinates, **changes: Any) -> NewtonEuler:
        """Return the mechanics along motions, some parts of which may be other ones."""
        return NewtonEuler(Kinematics(self.binding, replace(chart, **changes)))

    def _accelerations(self) -> list[Node]:
        """Solve M_ff v_dot_f = F_f for given driven accelerations."""
        tape, chart = self.tape, self.chart
        free = [k for k in range(len(chart.states)) if k not in chart.driven]
        given = combine(
            self.binding, [chart.directions[k] for k in chart.driven], chart.driven.values()
        )
        known = [tape.add(a, b) for a, b in zip(chart.accelerations, given, strict=True)]
        mechanics = self._along(chart, accelerations=known)
        M = mechanics.mass_matrix()
        self._check_masses(M, free)
        self._check_rate_inputs(free)
        loads = self._loads(mechanics)
        block = [[M[i][j] for j in free] for i in free]
        (solved,) = solve_definite(tape, block, [[loads[i] for i in free]], self.guards)
        matrix, right = (entry for row in block for entry in row), (loads[i] for i in free)
        first = len(self.binding.configuration)
        self.balance = tuple(first + k for k in free), tuple(matrix), tuple(right)
        accelerations = dict(zip(free, solved, strict=True)) | chart.driven
        return [accelerations[k] for k in range(len(chart.states))]

    def _loads(self, mechanics: NewtonEuler) -> list[Node]:
        """Return all forces minus the inertial forces of known accelerations."""
        tape = self.tape
        acting = zip(mechanics.conservative_forces(), mechanics.other_forces(), strict=True)
        parts = zip(acting, mechanics.inertial_forces(), strict=True)
        return [tape.sub(tape.add(*pair), inertial) for pair, inertial in parts]

    def _accelerations_by_multipliers(self) -> list[Node]:
        """Solve M nu_dot = F + A^T lambda with A nu_dot = -A_dot nu.

        Redundant constraints make A M^-1 A^T singular, but not the accelerations. What these lack
        is looked at after each refinement: forces on light parts cancel in it, not in multipliers.
        """
        tape = self.tape
        mechanics = self._along(self.chart)
        M = mechanics.mass_matrix()
        self._check_masses(M, list(range(len(M))))
        covectors = [row.covector for row in self.rows]
        free, *compliant = solve_definite(
            tape, M, [self._loads(mechanics), *covectors], self.guards
        )
        firm = self._firm_compliance(covectors, compliant)
        accelerations = list(free)
        for _ in range(ITERATIVE_REFINEMENTS):
            short = [
                tape.neg(tape.add(row.bias, tape.dot(row.covector, accelerations)))
                for row in self.rows
            ]
            (multipliers,) = solve_definite(tape, firm, [short], Guards())
            push = combine(self.binding, compliant, multipliers)
            accelerations = [tape.add(a, b) for a, b in zip(accelerations, push, strict=True)]
        return accelerations

    def _firm_compliance(
        self, covectors: Sequence[Sequence[Node]], compliant: Sequence[Sequence[Node]]
    ) -> list[list[Node]]:
        """Return A M^-1 A^T, regular also where rows are redundant.

        Each row is stiffened by its own compliance: that of a light part is many times larger than
        that of a heavy one, and would be taken for a redundant one otherwise.
        """
        tape, size = self.tape, len(covectors)
        G = [[tape.dot(a, c) for c in compliant] for a in covectors]
        whole = tape.mul(tape.constant(ROW_REGULARISATION), tape.sum(G[i][i] for i in range(size)))
        for i in range(size):  # a row that vanishes has none of its own
            own = tape.mul(tape.constant(ROW_REGULARISATION), tape.add(G[i][i], whole))
            G[i][i] = tape.add(G[i][i], own)
        return G

    def _least_norm(self, A: Sequence[Sequence[Node]], b: Sequence[Node]) -> list[Node]:
        """Solve A A^T x = b for the least-norm x, as by a pseudo-inverse.

        Iterative refinement removes the regularisation error; only its choice among the solutions
        of redundant constraints remains.

        Source: Golub, Van Loan, Matrix Computations, 4th ed., 3.5.3.
        """
        tape, size = self.tape, len(A)
        G = [[tape.dot(row, other) for other in A] for row in A]
        trace = tape.sum(G[i][i] for i in range(size))
        # 1e-8 relative to the constraints' compliance; makes redundant ones solvable
        trifle = tape.mul(tape.constant(1e-8), trace)
        firm = [
            [tape.add(G[i][j], trifle) if i == j else G[i][j] for j in range(size)]
            for i in range(size)
        ]
        x = [tape.zero] * size
        for _ in range(ITERATIVE_REFINEMENTS):
            missing = [tape.sub(each, tape.dot(row, x)) for each, row in zip(b, G, strict=True)]
            (step,) = solve_definite(tape, firm, [missing], Guards())
            x = [tape.add(entry, change) for entry, change in zip(x, step, strict=True)]
        return x

    def _unbalanced(self, nu_dot: Sequence[Node]) -> list[Node]:
        """Return M nu_dot + c - F in full coordinates: the forces of constraints and drives."""
        whole = unconstrained_coordinates(self.binding)
        mechanics = self._along(self.chart, accelerations=nu_dot, directions=whole.directions)
        return [self.tape.neg(load) for load in self._loads(mechanics)]

    def _constraint_forces(self, nu_dot: Sequence[Node]) -> tuple[Node, ...]:
        """Return the multipliers of the constraint rows, of least norm where rows are redundant."""
        tape = self.tape
        missing = self._unbalanced(nu_dot)
        if not self.multipliers:
            for k, i in enumerate(self.chart.independent, start=len(self.chart.quasi)):
                if k in self.chart.driven:
                    missing[i] = tape.zero  # the drive's own force, not a constraint's
            rows, dependent = self.chart.defining, self.chart.dependent
            block = [[row.covector[i] for row in rows] for i in dependent]
            (forces,) = solve_square(tape, block, [[missing[i] for i in dependent]], Guards())
            return tuple(forces[: len(self.rows)])  # no force acts along a quasi-velocity
        covectors = [row.covector for row in self.rows]
        projected = [tape.dot(covector, missing) for covector in covectors]
        return tuple(self._least_norm(covectors, projected))

    def _power(self, nu_dot: Sequence[Node]) -> Node:
        """Return the power of friction, wrenches, inputs, and of drives and rate inputs."""
        tape, whole = self.tape, unconstrained_coordinates(self.binding)
        mechanics = self._along(self.chart, directions=whole.directions)
        power = tape.dot(mechanics.other_forces(), self.chart.velocities)
        if self.chart.driven or self.chart.input_directions:
            power = tape.add(power, tape.dot(self._unbalanced(nu_dot), self.chart.velocities))
        return power

    def _residual(self) -> tuple[Node, ...]:
        """Return A nu of every constraint, redundant ones too, then h of position constraints."""
        rows = constraint_rows(self.binding)
        speeds = (self.tape.dot(row.covector, self.chart.velocities) for row in rows)
        return (*speeds, *self._gaps())

    def _gaps(self) -> list[Node]:
        return [self.binding.lower(closure.position) for closure in self.system.closures]

    def _requirements(self, forces: Sequence[Node]) -> tuple[Node, ...]:
        """Lower the requirements, with velocities and constraint forces substituted."""
        by_name = {row.name: force for row, force in zip(self.rows, forces, strict=False)}
        known = {
            symbol: by_name[symbol.name]
            for requirement in self.system.requirements
            for symbol in requirement.margin.free_symbols
            if isinstance(symbol, ForceSymbol) and symbol.name in by_name
        }
        lower = Lowering(self.tape, self.binding.lower.symbols | known)
        margins = [lower(requirement.margin) for requirement in self.system.requirements]
        return tuple(self.tape.substitute(margins, self.binding.at(self.chart.velocities)))

    def _projection(self) -> tuple[Node, ...]:
        """Return the state after one Newton step onto the constraints, unit vectors normalized."""
        spheres, gaps = spheres_of(self.binding.parts), self._gaps()
        if not (spheres or gaps or self.multipliers):
            return ()
        q = self._shifted(gaps) if gaps else list(self.binding.configuration)
        velocities = self._shifted_velocities() if self.multipliers else self.states
        for part in spheres:
            length = self.tape.unary("sqrt", self.tape.dot(q[part.own], q[part.own]))
            q[part.own] = [self.tape.div(entry, length) for entry in q[part.own]]
        return (*q, *velocities, *self.binding.states)

    def _shifted(self, gaps: list[Node]) -> list[Node]:
        """Move the configuration by the least-norm velocity that closes the gaps."""
        tape = self.tape
        closing = dict(zip((c.name for c in self.system.closures), gaps, strict=True))
        own = (row for row in self.rows if row.value == tape.zero)  # not those of rate inputs
        rows = [row for row in own if row.name in closing]
        covectors = [row.covector for row in rows]
        shares = self._least_norm(covectors, [tape.neg(closing[row.name]) for row in rows])
        move = combine(self.binding, covectors, shares)
        flow = self.binding.flow(move)
        return [tape.add(node, flow[node]) for node in self.binding.configuration]

    def _shifted_velocities(self) -> list[Node]:
        """Project the velocities onto those that the constraints allow."""
        tape = self.tape
        covectors = [row.covector for row in self.rows]
        excess = [tape.neg(tape.dot(covector, self.states)) for covector in covectors]
        change = combine(self.binding, covectors, self._least_norm(covectors, excess))
        return [tape.add(v, c) for v, c in zip(self.states, change, strict=True)]

    def _check_masses(self, M: list[list[Node]], free: list[int]) -> None:
        """Report a direction of motion without inertia.

        It must be massless at every sampled state: at a coordinate singularity, such as a spherical
        pendulum hanging straight down, any machine has a massless direction.
        """
        flat = [M[i][j] for i in free for j in free]
        massless: list[str] = []
        for values in feasible_values(self.binding) if free else ():
            try:
                matrix = np.reshape(self.tape.evaluate(flat, values), (len(free), len(free)))
            except (ArithmeticError, ValueError):
                continue  # no mass matrix where the pose is undefined
            if not np.isfinite(matrix).all():
                continue
            moved = _massless_motion(matrix)
            if not moved:
                return
            labels = [self.tape.operations[self.states[free[i]]].label for i in moved]
            massless = [label.removesuffix("_dot") for label in labels]
        if massless:
            what = f"no mass or inertia resists a motion of {', '.join(massless)}."
            remedy = _remedy_for(self.system, massless)
            raise InputError([Mistake(f"system {self.system.name!r}", what, remedy)])

    def _check_rate_inputs(self, free: list[int]) -> None:
        """Reject an imposed velocity that would accelerate mass."""
        chart = self.chart
        if not chart.input_directions:
            return
        directions = (*chart.directions, *chart.input_directions.values())
        M = self._along(chart, directions=directions).mass_matrix()
        for k, node in enumerate(chart.input_directions, start=len(chart.directions)):
            # the rate of a clock has no steps
            if node != self.tape.one and any(M[i][k] != self.tape.zero for i in free):
                name = self.tape.operations[node].label
                kind = "state" if node in self.binding.states else "input"
                what = "its steps would be blows to a machine that has mass."
                if kind == "state":
                    what = "it is the speed of a machine that has mass."
                remedy = "Make it a Drive, whose value is the acceleration."
                raise InputError([Mistake(f"{kind} {name!r}", what, remedy)])

    def _check_inputs(self, outputs: Sequence[Node]) -> None:
        """Report inputs without effect."""
        used = frozenset[Node]().union(*(self.tape.depends_on(node) for node in outputs))
        mistakes = [
            Mistake(f"input {entry.name!r}", "it reaches nothing.", entry.remedy)
            for entry, node in zip(self.system.inputs, self.binding.inputs, strict=True)
            if node not in used
        ]
        if mistakes:
            raise InputError(mistakes)


def _at_origin(frame: Frame) -> Iterator[Frame]:
    """Yield a frame, and it without its last turns: all have the same origin."""
    yield frame
    while frame.motions and not isinstance(frame.motions[-1], Translation):
        frame = Frame(frame.motions[:-1])
        yield frame


def _massless_motion(M: np.ndarray) -> list[int]:
    """Return the coordinates in a mass matrix's null space; empty where it is regular."""
    # Scaled so that each coordinate's own inertia is 1: kg and kg m^2 are not comparable.
    own = np.sqrt(np.maximum(np.diag(M), 0.0))
    own = np.where(own > 0, own, 1.0)
    eigenvalues, vectors = np.linalg.eigh(M / np.outer(own, own))
    # 1e-12 of a coordinate's own inertia that remains when the others move along
    if eigenvalues[0] > 1e-12:
        return []
    return [int(i) for i in np.flatnonzero(np.abs(vectors[:, 0]) > 0.1)]


def _remedy_for(system: Mechanism, coordinates: Sequence[str]) -> str:
    """Say what gives coordinates inertia: a missing body, or mass of those that move with them."""
    moved = []
    for body in system.bodies:
        own = {coordinate_of(atom) for atom in atoms_of(body.frame)}
        if any(c is not None and c.name in coordinates for c in own):
            moved.append(body)
    if not moved:
        named = " or ".join(coordinates)
        return f"No body moves with {named}: add the one that does to bodies."
    names = ", ".join(repr(body.name) for body in moved)
    weighed = [body for body in moved if not is_zero(body.mass)]
    if weighed:
        return (
            f"It turns {weighed[0].name!r} about its own centre only: give it an inertia, or mind "
            "the order of its frame's factors, as in rot_y(q) @ move(…), which swings it."
        )
    return f"Give {'one of ' * (len(moved) > 1)}{names} a mass or an inertia."


def _point_speed(binding: SymbolTable, shapes: Sequence[Shape], state: FrameState) -> Node:
    """Bound the speed of a body's points; spin about a shape's symmetry axis is ignored."""
    tape = binding.tape
    linear = _origin_speed(binding, state)
    fastest = tape.zero if shapes else linear
    for shape in shapes:
        extent = bounding_radius(shape)
        spin = [
            component
            for name, component in zip("xyz", state.velocity.angular, strict=True)
            if name not in extent.symmetric_about
        ]
        turning = tape.unary("sqrt", tape.dot(spin, spin)) if spin else tape.zero
        speed = tape.add(linear, tape.mul(turning, binding.lower(extent.radius)))
        fastest = tape.maximum(fastest, speed)
    return fastest


def _origin_speed(binding: SymbolTable, state: FrameState) -> Node:
    tape = binding.tape
    return tape.unary("sqrt", tape.dot(state.velocity.linear, state.velocity.linear))
