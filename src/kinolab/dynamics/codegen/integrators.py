"""Integrator steps as LLVM IR, and the linear algebra that an implicit one needs.

A step is made of as many substeps as the caller asks for. Every one ends by moving the state back
onto the constraints and unit spheres, where the machine has any.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from kinolab.dynamics.codegen.llvm import Register, Routine, in_lanes, literal
from kinolab.dynamics.codegen.methods import METHODS, Method
from kinolab.dynamics.codegen.trigonometry import sine_and_cosine
from kinolab.numerics.manifolds.state_parts import UnitSphere, spheres_of

if TYPE_CHECKING:  # what derives a machine: one that is in the cache needs none of it
    from kinolab.dynamics.derivation.derivation import Derivation


POINTERS = [("ptr", "x"), ("ptr", "u"), ("ptr", "p")]
LANES = 4  # results at once: as many as the widest registers of most processors have room for
RATE = [*POINTERS, ("ptr", "out"), ("i64", "mode")]
STEP = [*POINTERS, ("double", "h"), ("ptr", "out"), ("i64", "substeps"), ("i64", "mode")]


def steppers() -> tuple[str, ...]:
    """Return the names of the functions that make steps, one for each method there is."""
    return tuple(f"step_{name}" for name in METHODS)


def emit_integrators(derivation: Derivation, lanes: int = 1) -> list[str]:
    """Return one function per integration method; in lanes, per explicit one."""
    return [
        _emit_step(method, derivation, lanes)
        for method in METHODS.values()
        if lanes == 1 or not method.implicit
    ]


def _emit_step(method: Method, d: Derivation, lanes: int) -> str:
    """Return a step of a method; with ``geodesic``, along great circles where x is on a sphere."""
    routine = Routine(f"step_{method.name}{in_lanes(lanes)}", STEP, lanes=lanes)
    size, inputs = len(d.state), len(d.binding.inputs)
    at, total, begin, *k = (routine.array(size) for _ in range(3 + method.stages))
    status = routine.cell("i32", "0")
    count = routine.line("sitofp i64 %substeps to double")
    h = routine.div(routine.spread("%h"), routine.spread(count))
    routine.copy("%x", begin, size)
    with routine.loop(0, "%substeps"):
        solve = ""
        if method.implicit:
            solve = _factored(routine, (size, inputs), h, method.gamma, begin, status)
        routine.copy(begin, total, size)
        for i, (stage, weight) in enumerate(zip(k, method.b, strict=True)):
            source = begin
            for former, share in zip(k, method.a[i], strict=False):
                if share:
                    factor = routine.mul(h, routine.constant(share))
                    _axpy(routine, size, factor, former, source, at)
                    source = at
            failed = routine.call(f"@f{in_lanes(lanes)}", source, "%u", "%p", stage, noinline=True)
            routine.merge(status, failed)
            for former, share in zip(k, method.c[i] if method.c else (), strict=False):
                if share:
                    _axpy(routine, size, routine.constant(share), former, stage, stage)
            if solve:
                routine.do(f"{solve}, ptr {stage})")
            _axpy(routine, size, routine.mul(h, routine.constant(weight)), stage, total, total)
        for part in spheres_of(d.parts) if method.geodesic else ():
            _turn(routine, part, h, k[0], begin, total)
        if d.projection:  # twice: the second Newton step reaches rounding
            for places in ((total, "%p", begin), (begin, "%p", total)):
                failed = routine.call(f"@project{in_lanes(lanes)}", *places, noinline=True)
                routine.merge(status, failed)
        routine.copy(total, begin, size)
    routine.copy(begin, "%out", size)
    routine.give(routine.get("i32", status))
    return routine.text()


def _factored(
    routine: Routine,
    sizes: tuple[int, int],
    h: str,
    gamma: float,
    begin: Register,
    status: Register,
) -> str:
    """Factor 1 - gamma h J at the beginning of a step; returns the call that solves with it."""
    size, inputs = sizes
    jacobian = routine.array(size * (size + inputs))
    matrix, pivots = routine.array(size * size), routine.array(size)
    routine.merge(status, routine.call("@jacobian", begin, "%u", "%p", jacobian))
    fraction = routine.mul(h, literal(-gamma))
    with routine.loop(0, size) as i, routine.loop(0, size) as j:
        column = routine.integer("add", routine.integer("mul", j, size), i)
        row = routine.integer("add", routine.integer("mul", i, size), j)
        own = routine.line(f"icmp eq i64 {i}, {j}")
        one = routine.line(f"select i1 {own}, double {literal(1.0)}, double {literal(0.0)}")
        scaled = routine.mul(fraction, routine.load(jacobian, column))
        routine.store(matrix, row, routine.add(one, scaled))
    singular = routine.line(f"call i32 @lu_factor(ptr {matrix}, ptr {pivots}, i64 {size})")
    routine.merge(status, singular)
    return f"call void @lu_solve(ptr {matrix}, ptr {pivots}, i64 {size}"


def _turn(
    routine: Routine, part: UnitSphere, h: str, k: Register, begin: Register, total: Register
) -> None:
    """Set a unit vector of ``total`` to the end of the great circle along its derivative in ``k``.

    Of an attitude that is q exp(h w / 2): q_dot = q w / 2 is at right angles to q and |w| / 2 long.
    """
    q, q_dot = ([routine.load(array, i) for i in part.entries] for array in (begin, k))
    square = routine.constant(0.0)
    for entry in q_dot:
        square = routine.add(square, routine.mul(entry, entry))
    squared = routine.mul(routine.mul(h, h), square)
    turn = routine.intrinsic("sqrt", squared)
    sine, cosine = sine_and_cosine(routine, turn)
    # 1e-8 [rad^2] of half a turn, squared: sin(a)/a is 1 - a^2/6 to rounding
    small = routine.compare("olt", squared, routine.constant(1e-8))
    series = routine.sub(routine.constant(1.0), routine.div(squared, routine.constant(6.0)))
    ratio = routine.select(small, series, routine.div(sine, turn))
    fraction = routine.mul(h, ratio)
    for i, at, slope in zip(part.entries, q, q_dot, strict=True):
        routine.store(total, i, routine.add(routine.mul(cosine, at), routine.mul(fraction, slope)))


def _axpy(
    routine: Routine, size: int, factor: str, a: Register, b: Register, target: Register
) -> None:
    """Set target to factor * a + b."""
    with routine.loop(0, size) as i:
        product = routine.mul(factor, routine.load(a, i))
        routine.store(target, i, routine.add(routine.load(b, i), product))


def emit_linear_algebra() -> list[str]:
    """Return Gaussian elimination with row pivoting, and substitution.

    int lu_factor(double *A, double *pivots, long n), rows of A in place; nonzero if singular.
    void lu_solve(const double *A, const double *pivots, long n, double *b), b in place.

    Source: Golub, Van Loan, Matrix Computations, 4th ed., algorithm 3.4.1.
    """
    return [_emit_lu_factor(), _emit_lu_solve()]


def _emit_lu_factor() -> str:
    r = Routine("lu_factor", [("ptr", "A"), ("ptr", "pivots"), ("i64", "n")], private=True)
    status = r.cell("i32", "0")
    best, where = r.cell("double", literal(0.0)), r.cell("i64", "0")
    with r.loop(0, "%n") as k:
        r.put("double", best, literal(-1.0))
        with r.loop(k, "%n") as i:
            entry = r.load("%A", _entry(r, i, k))
            size = r.line(f"call double @llvm.fabs.f64(double {entry})")
            larger = r.line(f"fcmp ogt double {size}, {r.get('double', best)}")
            with r.when(larger):
                r.put("double", best, size)
                r.put("i64", where, i)
        row = r.get("i64", where)
        r.store("%pivots", k, r.line(f"sitofp i64 {row} to double"))
        usable = r.line(f"fcmp ogt double {r.get('double', best)}, {literal(1e-300)}")
        r.merge(status, r.line(f"select i1 {usable}, i32 0, i32 1"))
        with r.loop(0, "%n") as j:
            upper, lower = _entry(r, k, j), _entry(r, row, j)
            a, b = r.load("%A", upper), r.load("%A", lower)
            r.store("%A", upper, b)
            r.store("%A", lower, a)
        pivot = r.load("%A", _entry(r, k, k))
        with r.loop(r.integer("add", k, 1), "%n") as i:
            factor = r.div(r.load("%A", _entry(r, i, k)), pivot)
            r.store("%A", _entry(r, i, k), factor)
            with r.loop(r.integer("add", k, 1), "%n") as j:
                product = r.mul(factor, r.load("%A", _entry(r, k, j)))
                place = _entry(r, i, j)
                r.store("%A", place, r.sub(r.load("%A", place), product))
    r.give(r.get("i32", status))
    return r.text()


def _emit_lu_solve() -> str:
    parameters = [("ptr", "A"), ("ptr", "pivots"), ("i64", "n"), ("ptr", "b")]
    r = Routine("lu_solve", parameters, result="void", private=True)
    with r.loop(0, "%n") as k:  # all swaps first: the factors were swapped as whole rows
        row = r.line(f"fptosi double {r.load('%pivots', k)} to i64")
        a, b = r.load("%b", k), r.load("%b", row)
        r.store("%b", k, b)
        r.store("%b", row, a)
    with r.loop(0, "%n") as k, r.loop(r.integer("add", k, 1), "%n") as i:
        product = r.mul(r.load("%A", _entry(r, i, k)), r.load("%b", k))
        r.store("%b", i, r.sub(r.load("%b", i), product))
    with r.loop(0, "%n") as back:
        last = r.integer("sub", "%n", 1)
        k = r.integer("sub", last, back)
        value = r.div(r.load("%b", k), r.load("%A", _entry(r, k, k)))
        r.store("%b", k, value)
        with r.loop(0, k) as i:
            product = r.mul(r.load("%A", _entry(r, i, k)), value)
            r.store("%b", i, r.sub(r.load("%b", i), product))
    r.do("ret void")
    return r.text()


def _entry(r: Routine, i: str, j: str) -> Register:
    """Return the index of entry (i, j) of the n by n matrix."""
    return r.integer("add", r.integer("mul", i, "%n"), j)
