"""A second way to move a machine: Hamilton's principle made discrete by the midpoint rule.

One step goes from q0 to q1 through a midpoint m at the mean velocity w, with action h L(m, w):

    a line or circle    m = q0 + h w / 2     q1 = m + h w / 2
    an attitude         m = q0 s             q1 = m s            s = cay(h w / 2)

The action's slopes at both ends are momenta, p0 = -D1 L_d and p1 = D2 L_d, in body axes for an
attitude. With F = dL/dm plus the held forces and mu = dL/dw, all at (m, w),

    a line or circle    p0 = mu - h F / 2          p1 = mu + h F / 2
    an attitude         p0 = s (P - h F / 2)       p1 = s^T (P + h F / 2)
                        P = (1 + a.a) mu + h/2 a x F,    a = h w / 4

where (a, 1) is the quaternion of s but for its length. A step solves p0 = M(q0) nu0 + A(q0)^T
lambda with h(q1) = 0 for constraints of position and A(m) w = 0 for those of velocity. Nothing
here uses the equations of motion: everything is a derivative of the energies.

The rows of an attitude follow from the derivative of the Cayley map, s^T ds = (1 - a x) d(h w / 2)
/ (1 + a.a): from q0 = m s^T and q1 = m s, the slopes of the action along m and along w are

    s p1 - s^T p0 = h F,     (1 - a x) s p1 + (1 + a x) s^T p0 = 2 (1 + a.a) mu.

Sources:
    Marsden, West, Acta Numerica 10, 2001: momenta 1.5, held forces 3.2, constraints 3.4 and 3.5.
    Cortes, Martinez, Nonlinearity 14, 2001: the discrete Lagrange-d'Alembert principle.
    Bou-Rabee, Marsden, Found. Comput. Math. 9, 2009: retractions such as the Cayley map.
    Moser, Veselov, Commun. Math. Phys. 139, 1991: the free rigid body.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from kinolab.arguments import checked
from kinolab.dynamics.codegen.cache import COMPILED
from kinolab.dynamics.codegen.emission import declarations, emit_function
from kinolab.dynamics.codegen.integrators import emit_linear_algebra
from kinolab.dynamics.codegen.llvm import Register, Routine, literal
from kinolab.dynamics.codegen.llvm_jit import compile_ir, link
from kinolab.dynamics.codegen.trigonometry import emit_sine_and_cosine
from kinolab.dynamics.derivation.derivation import is_kinematic
from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.kinematics import Kinematics
from kinolab.dynamics.derivation.newton_euler import NewtonEuler
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.derivation.vectors import Vector, Vectors
from kinolab.dynamics.derivation.velocity_coordinates import (
    ConstraintRow,
    constraint_rows,
    unconstrained_coordinates,
)
from kinolab.dynamics.language.constraints import PositionConstraint
from kinolab.dynamics.language.forces import Coulomb, SlidingFriction, Viscous, Wrench
from kinolab.dynamics.language.inputs import Drive, Rate
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.model.model import Model
from kinolab.dynamics.symbols.symbols import Attitude
from kinolab.errors import InputError, Mistake, NoDynamicsError, SingularError
from kinolab.numerics.arrays import Array

NEWTON_STEPS = 30  # a step that is small enough needs three or four
CONSTRAINT_TOLERANCE = 1e-6  # [m], [rad] or those per s; what a start may miss them by
MAX_CONTRACTION = 0.5  # largest ratio of one Newton change to that before it
# last change of h w, relative to 1 + max |q|; its square is below rounding
NEWTON_TOLERANCE = 1e-12


@checked
@final
class VariationalIntegrator:
    """Steps a conservative machine so that its symmetries' momenta are kept to rounding.

    The method is of second order and its own inverse for -h. Without constraints of velocity it is
    symplectic: the energy error is of second order and does not grow with time. Constraints of
    position hold at every state, those of velocity at the midpoint of every step for its mean
    velocity; the velocities of every state satisfy both.

    Attributes:
        model: The machine's equations of motion, whose state layout is used; they are not.

    Args:
        system: A machine without friction, wrenches, drives, rate inputs and auxiliary states.

    Raises:
        InputError: If it has any of these.
        NoDynamicsError: If it is kinematic.
    """

    def __init__(self, system: Mechanism) -> None:
        _check(system)
        self.model = Model(system.with_feedback(None))  # it is pushed by inputs, not by a law
        content = f"variational {machine_to_json(system)}"
        _, code = COMPILED.get([content], lambda: ({}, _build(system, self.model.redundant)))
        self._library = link(code, ["march", "saddle"])
        self._rows = len(system.constraints) - len(self.model.redundant)

    def step(self, x: ArrayLike, h: float, u: ArrayLike = (), **parameters: float) -> Array:
        """Return the state after one step of length ``h`` in [s]; see ``run``."""
        after: Array = self.run(x, h, 1, u, **parameters)[1]
        return after

    def run(
        self, x0: ArrayLike, h: float, steps: int, u: ArrayLike = (), **parameters: float
    ) -> Array:
        """Return the states at 0, h, ..., steps * h, shape (steps + 1, nx).

        Args:
            x0: State at time zero, shape (nx,), on the constraints.
            h: Step length in [s]; negative to go back.
            steps: How many.
            u: Inputs, shape (nu,), held all the time; zero when left out.
            parameters: Values that override the system's.

        Raises:
            InputError: If an argument has a wrong shape, ``h`` is no step, or ``x0`` is not on the
                constraints.
            SingularError: If a step has no solution nearby, as where ``h`` is too large.
        """
        if not (math.isfinite(h) and h != 0):
            raise InputError([Mistake("", f"the step is {h}.", "Give a finite one in [s].")])
        if steps < 0:
            raise InputError(
                [Mistake("", f"the run has {steps} steps.", "Go back by a negative h.")]
            )
        x, controls = self._vector("x0", x0, self.model.nx), self._inputs(u)
        self._check_start(x, parameters)
        p, size = self.model.parameter_vector(**parameters), self.model.nq + self.model.nt
        travel = np.empty((steps + 1, size))
        travel[0, : self.model.nq] = x[: self.model.nq]
        travel[0, self.model.nq :], momentum = self._departure(x, p)
        arrays = (travel, momentum, controls, p, np.array([h], dtype=float))
        done = self._march(steps, *(array.ctypes.data for array in arrays))
        if done < steps:
            raise SingularError(self._failure(travel[done], done * h))
        columns = [*range(self.model.nq), *(self.model.nq + i for i in self.model.independent)]
        return travel[:, columns]

    def _check_start(self, x: Array, parameters: dict[str, float]) -> None:
        """Refuse a start that a step would have to jump away from."""
        excess = np.abs(self.model.constraint_residual(x, **parameters))
        if excess.size and not excess.max() < CONSTRAINT_TOLERANCE:
            where = f"system {self.model.system.name!r}"
            what = f"x0 misses its constraints by {excess.max():.3g}."
            raise InputError([Mistake(where, what, "Move it onto them with Model.project.")])

    def _departure(self, x: Array, p: Array) -> tuple[Array, Array]:
        """Return all velocities of a state and the momenta M nu, both of shape (nt,)."""
        nq, nt, rows = self.model.nq, self.model.nt, self._rows
        q, v = x[:nq].copy(), x[nq:].copy()
        K = np.empty((nt + rows, nt + rows))
        self._saddle(q.ctypes.data, p.ctypes.data, K.ctypes.data, 0)
        if len(v) == nt:
            return v, K[:nt, :nt] @ v
        chosen = np.eye(nt)[list(self.model.independent)]
        try:
            nu = np.linalg.solve(
                np.vstack([K[nt:, :nt], chosen]), np.concatenate([np.zeros(rows), v])
            )
        except np.linalg.LinAlgError as error:
            raise SingularError(self._failure(x, 0.0)) from error
        return nu, K[:nt, :nt] @ nu

    def _inputs(self, u: ArrayLike) -> Array:
        values = np.asarray(u, dtype=float)
        return self._vector("u", values if values.size else np.zeros(self.model.nu), self.model.nu)

    def _vector(self, name: str, values: ArrayLike, size: int) -> Array:
        vector = np.array(values, dtype=float)
        if vector.shape != (size,):
            what = f"{name} has shape {vector.shape}; it must be ({size},)."
            raise InputError([Mistake(f"system {self.model.system.name!r}", what)])
        return vector

    def _failure(self, q: Array, time: float) -> str:
        names = self.model.coordinate_names
        state = ", ".join(f"{n}={value:.6g}" for n, value in zip(names, q, strict=False))
        return (
            f"{self.model.system.name}: the step at {time:.6g} s from {state} has no solution "
            "nearby. Take shorter steps, or start away from poles of the coordinates."
        )

    @cached_property
    def _march(self) -> Callable[..., int]:
        types = (ctypes.c_int64, *(ctypes.c_void_p,) * 5)
        return ctypes.CFUNCTYPE(ctypes.c_int64, *types)(self._library.address("march"))

    @cached_property
    def _saddle(self) -> Callable[..., int]:
        types = (*(ctypes.c_void_p,) * 3, ctypes.c_int64)
        return ctypes.CFUNCTYPE(ctypes.c_int32, *types)(self._library.address("saddle"))


def _check(system: Mechanism) -> None:
    """Refuse what does not follow from energies, constraints and held forces."""
    if is_kinematic(system):
        text = f"{system.name} is kinematic: it has no energy, so no action. Use Model.step."
        raise NoDynamicsError(text)
    remedy = "Leave it out, or use Model.step."
    kinds: dict[type, str] = dict.fromkeys((Viscous, Coulomb, SlidingFriction), "friction")
    kinds[Wrench] = "a wrench"
    found = [kinds[type(effort)] for effort in system.efforts if type(effort) in kinds]
    found += [f"the drive {entry.name!r}" for entry in system.inputs if isinstance(entry, Drive)]
    found += [f"the rate {entry.name!r}" for entry in system.inputs if isinstance(entry, Rate)]
    found += [f"the auxiliary state {entry.name!r}" for entry in system.states]
    where = f"system {system.name!r}"
    mistakes = [
        Mistake(where, f"a variational integrator does not serve {what}.", remedy)
        for what in dict.fromkeys(found)
    ]
    if mistakes:
        raise InputError(mistakes)


def _build(system: Mechanism, redundant: Sequence[str]) -> bytes:
    """Compile the functions of one machine."""
    step = _VariationalStep(system, redundant)
    binding, tape = step.binding, step.binding.tape
    q, p, u = binding.configuration, binding.parameters, binding.inputs
    known = {"q": q, "z": (*step.mean, *step.impulses), "u": u, "p": p, "h": (step.h,)}
    equations = step.equations()
    residual_of = {**known, "start": step.start}
    sizes = _Sizes(len(q), len(step.mean), len(step.impulses))
    text = [
        *declarations(),
        emit_sine_and_cosine(1),
        emit_function("equations", tape, residual_of, equations),
        emit_function("arrive", tape, known, (*step.arrival, *step.momenta[1])),
        emit_function("saddle", tape, {"q": q, "p": p}, step.saddle()),
        *emit_linear_algebra(),
        _emit_newton(sizes),
        _emit_march(sizes),
    ]
    return compile_ir("\n".join(text))


class _VariationalStep:
    """One step of a machine as nodes of a tape.

    Attributes:
        binding: The tape; its configuration is q0.
        h: The step.
        mean: Variables of w, shape (nt,).
        impulses: Variables of lambda, one per constraint that is not redundant.
        start: Variables of the momenta at q0, shape (nt,).
        rows: Those constraints' rows A(q0).
    """

    def __init__(self, system: Mechanism, redundant: Sequence[str]) -> None:
        self.system, self.binding = system, SymbolTable.of(system)
        tape = self.tape = self.binding.tape
        self.vectors = Vectors(tape)
        names = [tape.operations[node].label for node in self.binding.tangent]
        rows = constraint_rows(self.binding)
        self.rows: list[ConstraintRow] = [row for row in rows if row.name not in redundant]
        self.h = tape.variable("step length")
        self.mean = tuple(tape.variable(f"mean {name}") for name in names)
        self.start = tuple(tape.variable(f"start {name}") for name in names)
        self.impulses = tuple(tape.variable(f"impulse {row.name}") for row in self.rows)

    def equations(self) -> tuple[Node, ...]:
        """Return what a step makes zero, then its derivative in (w, lambda) row by row."""
        tape = self.tape
        push = [tape.dot(column, self.impulses) for column in self._columns()]
        balance = [
            tape.sub(p0, tape.add(start, force))
            for p0, start, force in zip(self.momenta[0], self.start, push, strict=True)
        ]
        residual = [*balance, *self._conditions()]
        columns = [tape.derivative(residual, {z: tape.one}) for z in (*self.mean, *self.impulses)]
        return (*residual, *(entry for row in zip(*columns, strict=True) for entry in row))

    def saddle(self) -> tuple[Node, ...]:
        """Return [[M, A^T], [A, 0]] at the configuration, row by row; M = d^2 L / d nu^2."""
        tape = self.tape
        momenta = self._slopes[1]
        columns = [tape.derivative(momenta, {v: tape.one}) for v in self.binding.tangent]
        M = zip(*columns, strict=True)
        upper = ((*row, *column) for row, column in zip(M, self._columns(), strict=True))
        lower = ((*row.covector, *(tape.zero,) * len(self.rows)) for row in self.rows)
        return tuple(entry for row in (*upper, *lower) for entry in row)

    @cached_property
    def momenta(self) -> tuple[list[Node], list[Node]]:
        """p0 and p1 of the step, as the top of this file says, each of shape (nt,)."""
        forces, means = self._midpoint_slopes
        ends: tuple[list[Node], list[Node]] = ([], [])
        for _, at, attitude in _places(self.system):
            pair = (
                self._turning_momenta(at, forces[at : at + 3], means[at : at + 3])
                if attitude
                else self._straight_momenta(forces[at], means[at])
            )
            for whole, part in zip(ends, pair, strict=True):
                whole.extend(part)
        return ends

    @cached_property
    def arrival(self) -> list[Node]:
        """q1, its quaternions of unit length."""
        tape, q1 = self.tape, list[Node]()
        for place, at, attitude in _places(self.system):
            if attitude:
                q = [self._midpoint[node] for node in self.binding.configuration[place : place + 4]]
                turned = self._turned(q, self._turn(at))
                length = tape.unary("sqrt", tape.dot(turned, turned))
                q1 += [tape.div(entry, length) for entry in turned]
            else:
                q1.append(self._moved(place, at, 1.0))
        return q1

    @cached_property
    def _slopes(self) -> tuple[list[Node], list[Node]]:
        """F and mu as functions of q and nu, each of shape (nt,)."""
        tape, binding = self.tape, self.binding
        chart = unconstrained_coordinates(binding)
        mechanics = NewtonEuler(Kinematics(binding, chart))
        kinetic, potential = mechanics.energy()
        L = [tape.sub(kinetic, potential)]
        slopes = [tape.derivative(L, binding.flow(e))[0] for e in chart.directions]
        forces = [tape.add(a, b) for a, b in zip(slopes, mechanics.other_forces(), strict=True)]
        return forces, [tape.derivative(L, {v: tape.one})[0] for v in binding.tangent]

    @cached_property
    def _midpoint_slopes(self) -> tuple[list[Node], list[Node]]:
        actual = {**self._midpoint, **self.binding.at(self.mean)}
        forces, means = (self.tape.substitute(part, actual) for part in self._slopes)
        return forces, means

    @cached_property
    def _midpoint(self) -> dict[Node, Node]:
        """The midpoint m, by the nodes of q0."""
        tape, m = self.tape, list[Node]()
        for place, at, attitude in _places(self.system):
            if attitude:
                a = self._turn(at)
                length = tape.unary("sqrt", tape.add(tape.one, tape.dot(a, a)))
                turned = self._turned(self.binding.configuration[place : place + 4], a)
                m += [tape.div(entry, length) for entry in turned]
            else:
                m.append(self._moved(place, at, 0.5))
        return dict(zip(self.binding.configuration, m, strict=True))

    def _moved(self, place: int, at: int, fraction: float) -> Node:
        tape = self.tape
        path = tape.mul(tape.constant(fraction), tape.mul(self.h, self.mean[at]))
        return tape.add(self.binding.configuration[place], path)

    def _turn(self, at: int) -> Vector:
        """Return a = h w / 4 of the attitude whose velocities begin at an index."""
        quarter = self.tape.mul(self.tape.constant(0.25), self.h)
        return self.vectors.scale(quarter, self.vectors.vector(self.mean[at : at + 3]))

    def _turned(self, quaternion: Sequence[Node], a: Vector) -> list[Node]:
        """Return the product of a quaternion x, y, z, w and (a, 1)."""
        tape, vectors = self.tape, self.vectors
        u, w = vectors.vector(quaternion[:3]), quaternion[3]
        return [
            *vectors.add(u, vectors.scale(w, a), vectors.cross(u, a)),
            tape.sub(w, tape.dot(u, a)),
        ]

    def _straight_momenta(self, force: Node, mean: Node) -> tuple[list[Node], list[Node]]:
        tape = self.tape
        half = tape.mul(tape.mul(tape.constant(0.5), self.h), force)
        return [tape.sub(mean, half)], [tape.add(mean, half)]

    def _turning_momenta(
        self, at: int, force: Sequence[Node], mean: Sequence[Node]
    ) -> tuple[list[Node], list[Node]]:
        tape, vectors = self.tape, self.vectors
        a, mu = self._turn(at), vectors.vector(mean)
        half = vectors.scale(tape.mul(tape.constant(0.5), self.h), vectors.vector(force))
        stretch = tape.add(tape.one, tape.dot(a, a))
        P = vectors.add(vectors.scale(stretch, mu), vectors.cross(a, half))
        before = self._rotated(a, vectors.sub(P, half))
        back = vectors.scale(tape.constant(-1.0), a)
        return list(before), list(self._rotated(back, vectors.add(P, half)))

    def _rotated(self, a: Vector, vector: Vector) -> Vector:
        """Return s v = v + 2 (a x v + a x (a x v)) / (1 + a.a), Rodrigues' formula."""
        tape, vectors = self.tape, self.vectors
        swept = vectors.cross(a, vector)
        fraction = tape.div(tape.constant(2.0), tape.add(tape.one, tape.dot(a, a)))
        return vectors.add(
            vector, vectors.scale(fraction, vectors.add(swept, vectors.cross(a, swept)))
        )

    def _columns(self) -> list[list[Node]]:
        """Return the rows of A^T at q0."""
        return [[row.covector[i] for row in self.rows] for i in range(len(self.mean))]

    def _conditions(self) -> list[Node]:
        """Return h(q1) / h of constraints of position and A(m) w of those of velocity."""
        tape = self.tape
        positions = {
            c.name: c.position for c in self.system.constraints if isinstance(c, PositionConstraint)
        }
        arrived = dict(zip(self.binding.configuration, self.arrival, strict=True))
        conditions = []
        for row in self.rows:
            if row.name in positions:
                (gap,) = tape.substitute([self.binding.lower(positions[row.name])], arrived)
                conditions.append(tape.div(gap, self.h))
            else:
                covector = tape.substitute(row.covector, self._midpoint)
                conditions.append(tape.dot(covector, self.mean))
        return conditions


def _places(system: Mechanism) -> Iterator[tuple[int, int, bool]]:
    """Yield where each coordinate begins in q and in nu, and whether it is an attitude."""
    place = at = 0
    for coordinate in system.coordinates:
        attitude = isinstance(coordinate, Attitude)
        yield place, at, attitude
        place, at = (place + 4, at + 3) if attitude else (place + 1, at + 1)


@dataclass(frozen=True)
class _Sizes:
    """Lengths of q, of nu, and of lambda."""

    q: int
    nu: int
    impulses: int

    @property
    def unknowns(self) -> int:
        return self.nu + self.impulses


def _emit_newton(sizes: _Sizes) -> str:
    """Return the solution of one step, from and to z = (w, lambda); nonzero where it fails.

    Changes that do not shrink would lead to a solution that is no neighbour of the start.

    Source: Deuflhard, Newton Methods for Nonlinear Problems, 2004, chapter 2.
    """
    pointers = ("q", "z", "u", "p", "h", "start")
    r = Routine("newton", [("ptr", name) for name in pointers], private=True)
    n = sizes.unknowns
    move, pivots = r.array(n + n * n), r.array(n)
    jacobian = r.at(move, n)
    enough, before = _tolerance(r, sizes), r.cell("double", literal(math.inf))
    arguments = ", ".join(f"ptr %{name}" for name in pointers)
    with r.loop(0, NEWTON_STEPS):
        failed = r.line(f"call i32 @equations({arguments}, ptr {move}, i64 0)")
        singular = _solve(r, jacobian, pivots, n, move)
        with r.loop(0, n) as i:
            r.store("%z", i, r.sub(r.load("%z", i), r.load(move, i)))
        _give_if(r, r.line(f"icmp ne i32 {r.line(f'or i32 {failed}, {singular}')}, 0"), "1")
        largest = _largest(r, move, sizes.nu, literal(0.0))
        _give_if(r, r.line(f"fcmp ole double {largest}, {enough}"), "0")
        bound = r.mul(literal(MAX_CONTRACTION), r.get("double", before))
        _give_if(r, r.line(f"fcmp ogt double {largest}, {bound}"), "1")
        r.put("double", before, largest)
    r.give("1")
    return r.text()


def _tolerance(r: Routine, sizes: _Sizes) -> Register:
    """Return what a change of w may be at the end, in units of w."""
    reach = r.add(literal(1.0), _largest(r, "%q", sizes.q, literal(0.0)))
    length = r.line(f"call double @llvm.fabs.f64(double {r.load('%h', 0)})")
    return r.div(r.mul(literal(NEWTON_TOLERANCE), reach), length)


def _largest(r: Routine, array: Register, size: int, least: str) -> Register:
    """Return the largest magnitude of an array's first entries, NaN left out."""
    cell = r.cell("double", least)
    with r.loop(0, size) as i:
        entry = r.line(f"call double @llvm.fabs.f64(double {r.load(array, i)})")
        pair = f"double {entry}, double {r.get('double', cell)}"
        r.put("double", cell, r.line(f"call double @llvm.maxnum.f64({pair})"))
    return r.get("double", cell)


def _solve(r: Routine, matrix: Register, pivots: Register, n: int, b: Register) -> Register:
    """Solve in place; returns nonzero where the matrix is singular."""
    singular = r.line(f"call i32 @lu_factor(ptr {matrix}, ptr {pivots}, i64 {n})")
    r.do(f"call void @lu_solve(ptr {matrix}, ptr {pivots}, i64 {n}, ptr {b})")
    return singular


def _give_if(r: Routine, condition: Register, value: str) -> None:
    mark = r.fork(condition)
    r.give(value)
    r.join(mark)


def _emit_march(sizes: _Sizes) -> str:
    """Return the loop over steps; its result is how many succeeded.

    long march(long steps, double *travel, double *momentum, *u, *p, *h)

    travel holds rows of (q, nu); its first row is given.
    """
    pointers = [("ptr", name) for name in ("travel", "momentum", "u", "p", "h")]
    r = Routine("march", [("i64", "steps"), *pointers], result="i64")
    n, width = sizes.unknowns, sizes.q + sizes.nu
    z, end = r.array(n), r.array(width)
    matrix, pivots, nu = r.array(n * n), r.array(n), r.array(n)
    with r.loop(0, n) as i:
        r.store(z, i, literal(0.0))
    with r.loop(0, "%steps") as k:
        q = r.at("%travel", r.integer("mul", k, width))
        following = r.at(q, width)
        r.copy(r.at(q, sizes.q), z, sizes.nu)  # the velocity is near the mean one
        call = f"call i32 @newton(ptr {q}, ptr {z}, ptr %u, ptr %p, ptr %h, ptr %momentum)"
        _give_if(r, r.line(f"icmp ne i32 {r.line(call)}, 0"), k)
        r.do(f"call i32 @arrive(ptr {q}, ptr {z}, ptr %u, ptr %p, ptr %h, ptr {end}, i64 0)")
        r.copy(end, following, sizes.q)
        r.copy(r.at(end, sizes.q), "%momentum", sizes.nu)
        r.copy("%momentum", nu, sizes.nu)
        with r.loop(sizes.nu, n) as i:
            r.store(nu, i, literal(0.0))
        r.do(f"call i32 @saddle(ptr {following}, ptr %p, ptr {matrix}, i64 0)")
        singular = _solve(r, matrix, pivots, n, nu)
        _give_if(r, r.line(f"icmp ne i32 {singular}, 0"), k)
        r.copy(nu, r.at(following, sizes.q), sizes.nu)
    r.give("%steps")
    return r.text()
