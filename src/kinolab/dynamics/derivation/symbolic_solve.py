"""Symbolic solution of small linear systems, as branch-free expressions with guards.

A guard is a node that must be positive for the solution to be valid; compiled code checks it and
reports failure.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import TypeAlias

from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node

Matrix: TypeAlias = Sequence[Sequence[Node]]


@dataclass
class Guards:
    """The guards collected while equations are solved; each node must be positive."""

    nodes: list[Node] = field(default_factory=list)

    def require(self, tape: ExpressionGraph, node: Node) -> None:
        """Add a guard; a positive constant needs no check."""
        value = tape.value(node)
        if value is None or not value > 0:
            self.nodes.append(node)


@dataclass(frozen=True)
class _Definite:
    """The solution x of M x = b with M = L D L^T; M dx = db - dM x has the same factors."""

    tape: ExpressionGraph
    M: Matrix
    b: Sequence[Node]
    lower: Matrix
    pivots: Sequence[Node]
    x: Sequence[Node]

    def tangents(self, of: Callable[[Node], Node]) -> list[tuple[Node, Node]]:
        """Return each entry of x with its tangent, given those of M and b."""
        tape, size = self.tape, len(self.M)
        dM = [[of(self.M[max(i, j)][min(i, j)]) for j in range(size)] for i in range(size)]
        right = [
            tape.sub(of(value), tape.dot(row, self.x))
            for value, row in zip(self.b, dM, strict=True)
        ]
        found = _substitute(tape, self.lower, self.pivots, right)
        return list(zip(self.x, found, strict=True))


def solve_definite(
    tape: ExpressionGraph, M: Matrix, columns: Matrix, guards: Guards
) -> list[list[Node]]:
    """Solve M X = B for a symmetric positive definite M by M = L D L^T, which needs no pivoting.

    Args:
        M: Shape (n, n).
        columns: The columns of B, each of length n.

    Returns:
        The columns of X.

    Source: Golub, Van Loan, Matrix Computations, 4th ed., 4.1.2.
    """
    known = len(tape.operations)
    lower, pivots = _factor(tape, M, guards)
    solved = [_substitute(tape, lower, pivots, column) for column in columns]
    if len(M) >= 8:  # from which a factorisation is too long to be differentiated itself
        for column, x in zip(columns, solved, strict=True):
            # What was there before, such as b where M is 1, is part of the equations itself.
            found = (node for node in x if node >= known)
            tape.solves(_Definite(tape, M, column, lower, pivots, x), found)
    return solved


def solve_square(
    tape: ExpressionGraph, A: Matrix, columns: Matrix, guards: Guards, rows: Matrix | None = None
) -> list[list[Node]]:
    """Solve A X = B for a square A: by Cramer's rule up to size 6, by normal equations above.

    Neither pivots at run time, and both are smooth wherever A is regular, so that the solution can
    be differentiated.

    Args:
        A: Shape (n, n).
        columns: The columns of B, each of length n.
        guards: Receive the conditions under which A is far from singular.
        rows: Full rows that A's columns are selected from, whose norms scale the guard; A itself
            when left out, which cannot tell whether a 1x1 matrix is small.
    """
    size = len(A)
    given = _given(tape, A)
    if given:
        return _solve_without(tape, A, columns, guards, rows or A, given)
    if not A:
        return [[] for _ in columns]
    if size <= 6:  # up to which cofactors take fewer operations than elimination
        return _solve_by_cofactors(tape, A, columns, guards, rows or A)
    transposed = list(zip(*A, strict=True))
    normal = [[tape.dot(a, b) for b in transposed] for a in transposed]
    right = [[tape.dot(a, column) for a in transposed] for column in columns]
    return solve_definite(tape, normal, right, guards)


def _given(tape: ExpressionGraph, A: Matrix) -> dict[int, int]:
    """Return the rows with a single unknown, and that unknown."""
    alone = {}
    for i, row in enumerate(A):
        entries = [j for j, entry in enumerate(row) if entry != tape.zero]
        if len(entries) == 1 and tape.value(row[entries[0]]) is not None:
            alone[i] = entries[0]
    return alone if len(set(alone.values())) == len(alone) else {}


def _solve_without(
    tape: ExpressionGraph,
    A: Matrix,
    columns: Matrix,
    guards: Guards,
    source: Matrix,
    given: dict[int, int],
) -> list[list[Node]]:
    """Solve for the unknowns that single rows determine, then for the others."""
    size = len(A)
    rows = [i for i in range(size) if i not in given]
    others = [j for j in range(size) if j not in given.values()]
    known = [{j: tape.div(column[i], A[i][j]) for i, j in given.items()} for column in columns]
    right = [
        [
            tape.sub(column[i], tape.sum(tape.mul(A[i][j], value) for j, value in found.items()))
            for i in rows
        ]
        for column, found in zip(columns, known, strict=True)
    ]
    block = [[A[i][j] for j in others] for i in rows]
    rest = solve_square(tape, block, right, guards, [source[i] for i in rows])
    solutions = []
    for found, part in zip(known, rest, strict=True):
        whole = found | dict(zip(others, part, strict=True))
        solutions.append([whole[j] for j in range(size)])
    return solutions


def _factor(
    tape: ExpressionGraph, M: Matrix, guards: Guards
) -> tuple[list[list[Node]], list[Node]]:
    size = len(M)
    lower = [[tape.zero] * size for _ in range(size)]
    pivots: list[Node] = []
    for j in range(size):
        squares = (tape.mul(tape.mul(lower[j][k], lower[j][k]), pivots[k]) for k in range(j))
        pivot = tape.sub(M[j][j], tape.sum(squares))
        pivots.append(pivot)
        # 1e-12 relative to the diagonal; a smaller pivot has lost all its digits
        floor = tape.mul(tape.constant(1e-12), M[j][j])
        guards.require(tape, tape.sub(pivot, floor) if j else pivot)
        for i in range(j + 1, size):
            products = (tape.mul(tape.mul(lower[i][k], lower[j][k]), pivots[k]) for k in range(j))
            lower[i][j] = tape.div(tape.sub(M[i][j], tape.sum(products)), pivot)
    return lower, pivots


def _substitute(
    tape: ExpressionGraph, lower: Matrix, pivots: Sequence[Node], column: Sequence[Node]
) -> list[Node]:
    size = len(pivots)
    forward: list[Node] = []
    for i in range(size):
        forward.append(tape.sub(column[i], tape.dot(lower[i][:i], forward)))
    solution = [tape.div(value, pivot) for value, pivot in zip(forward, pivots, strict=True)]
    for i in reversed(range(size)):
        later = (tape.mul(lower[k][i], solution[k]) for k in range(i + 1, size))
        solution[i] = tape.sub(solution[i], tape.sum(later))
    return solution


def _solve_by_cofactors(
    tape: ExpressionGraph, A: Matrix, columns: Matrix, guards: Guards, source: Matrix
) -> list[list[Node]]:
    size = len(A)

    @cache
    def minor(rows: tuple[int, ...], columns: tuple[int, ...]) -> Node:
        """Return a minor by Laplace expansion along its first row."""
        if not rows:
            return tape.one
        total = tape.zero
        for k, column in enumerate(columns):
            entry = A[rows[0]][column]
            if entry != tape.zero:
                rest = columns[:k] + columns[k + 1 :]
                fraction = tape.mul(entry, minor(rows[1:], rest))
                total = tape.sub(total, fraction) if k % 2 else tape.add(total, fraction)
        return total

    def cofactor(i: int, j: int) -> Node:
        found = minor(*(tuple(m for m in range(size) if m != k) for k in (i, j)))
        return tape.neg(found) if (i + j) % 2 else found

    cofactors = [[cofactor(i, j) for j in range(size)] for i in range(size)]
    determinant = tape.dot(A[0], cofactors[0])
    if determinant == tape.zero:
        raise ZeroDivisionError("the constraints do not determine these velocities")
    # det^2 above a fraction of the product of squared row norms (Hadamard's bound)
    bound = tape.one
    for row in source:
        bound = tape.mul(bound, tape.dot(row, row))
    square = tape.mul(determinant, determinant)
    # 1e-8 relative to the rows' norms; a smaller determinant counts as singular
    guards.require(tape, tape.sub(square, tape.mul(tape.constant(1e-8**2), bound)))
    return [
        [
            tape.div(tape.dot((cofactors[i][j] for i in range(size)), column), determinant)
            for j in range(size)
        ]
        for column in columns
    ]
