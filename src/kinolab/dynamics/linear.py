"""Small linear systems as straight-line code on a tape, with guards against singular ones.

A guard is a node that must be positive where the solution is to be trusted; compiled code checks
it and reports failure.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from kinolab.dynamics.tape import Node, Tape

Matrix: TypeAlias = Sequence[Sequence[Node]]

PIVOT_FLOOR = 1e-12  # a pivot this far below its diagonal has lost all its digits
CHART_FLOOR = 1e-8  # inverse condition number, squared, below which a chart counts as left


@dataclass
class Guards:
    """The conditions gathered while equations are solved; each node must be positive."""

    nodes: list[Node] = field(default_factory=list)

    def require(self, tape: Tape, node: Node) -> None:
        """Add a condition; one that is a positive constant needs no check."""
        value = tape.value(node)
        if value is None or not value > 0:
            self.nodes.append(node)


def solve_definite(tape: Tape, M: Matrix, columns: Matrix, guards: Guards) -> list[list[Node]]:
    """Solve M X = B for a symmetric positive definite M by M = L D L^T, which needs no pivoting.

    Args:
        M: Shape (n, n).
        columns: The columns of B, each of length n.

    Returns:
        The columns of X.

    Source: Golub, Van Loan, Matrix Computations, 4th ed., 4.1.2.
    """
    lower, pivots = _factor(tape, M, guards)
    return [_substitute(tape, lower, pivots, column) for column in columns]


def solve_square(tape: Tape, A: Matrix, columns: Matrix, guards: Guards) -> list[list[Node]]:
    """Solve A X = B for a square A: by cofactors up to size 3, by Givens rotations above.

    Both are stable without a choice of pivots at run time.

    Source: Golub, Van Loan, Matrix Computations, 4th ed., 5.2.5.
    """
    if not A:
        return [[] for _ in columns]
    if len(A) <= 3:
        return _solve_by_cofactors(tape, A, columns, guards)
    return _solve_by_rotations(tape, A, columns, guards)


def _factor(tape: Tape, M: Matrix, guards: Guards) -> tuple[list[list[Node]], list[Node]]:
    size = len(M)
    lower = [[tape.zero] * size for _ in range(size)]
    pivots: list[Node] = []
    for j in range(size):
        squares = (tape.mul(tape.mul(lower[j][k], lower[j][k]), pivots[k]) for k in range(j))
        pivot = tape.sub(M[j][j], tape.sum(squares))
        pivots.append(pivot)
        floor = tape.mul(tape.constant(PIVOT_FLOOR), M[j][j])
        guards.require(tape, tape.sub(pivot, floor) if j else pivot)
        for i in range(j + 1, size):
            products = (tape.mul(tape.mul(lower[i][k], lower[j][k]), pivots[k]) for k in range(j))
            lower[i][j] = tape.div(tape.sub(M[i][j], tape.sum(products)), pivot)
    return lower, pivots


def _substitute(
    tape: Tape, lower: Matrix, pivots: Sequence[Node], column: Sequence[Node]
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


def _solve_by_cofactors(tape: Tape, A: Matrix, columns: Matrix, guards: Guards) -> list[list[Node]]:
    size = len(A)
    cofactors = [[_cofactor(tape, A, i, j) for j in range(size)] for i in range(size)]
    determinant = tape.dot(A[0], cofactors[0])
    if determinant == tape.zero:
        raise ZeroDivisionError("the constraints do not determine these velocities")
    _guard_determinant(tape, A, determinant, guards)
    return [
        [
            tape.div(tape.dot((cofactors[i][j] for i in range(size)), column), determinant)
            for j in range(size)
        ]
        for column in columns
    ]


def _cofactor(tape: Tape, A: Matrix, i: int, j: int) -> Node:
    rows = [k for k in range(len(A)) if k != i]
    columns = [k for k in range(len(A)) if k != j]
    if not rows:
        return tape.one
    if len(rows) == 1:
        minor = A[rows[0]][columns[0]]
    else:
        (a, b), (c, d) = ([A[r][s] for s in columns] for r in rows)
        minor = tape.sub(tape.mul(a, d), tape.mul(b, c))
    return tape.neg(minor) if (i + j) % 2 else minor


def _guard_determinant(tape: Tape, A: Matrix, determinant: Node, guards: Guards) -> None:
    """Require det^2 to be a fair share of the product of the rows' squared lengths (Hadamard)."""
    bound = tape.one
    for row in A:
        bound = tape.mul(bound, tape.dot(row, row))
    square = tape.mul(determinant, determinant)
    guards.require(tape, tape.sub(square, tape.mul(tape.constant(CHART_FLOOR**2), bound)))


def _solve_by_rotations(tape: Tape, A: Matrix, columns: Matrix, guards: Guards) -> list[list[Node]]:
    size = len(A)
    rows = [[*A[i], *(column[i] for column in columns)] for i in range(size)]
    for j in range(size):
        for i in range(j + 1, size):
            if rows[i][j] != tape.zero:
                rows[j], rows[i] = _rotate(tape, rows[j], rows[i], j)
        diagonal, length = rows[j][j], tape.dot(rows[j][:size], rows[j][:size])
        floor = tape.mul(tape.constant(CHART_FLOOR**2), length)
        guards.require(tape, tape.sub(tape.mul(diagonal, diagonal), floor))
    return [_back_substitute(tape, rows, size, size + k) for k in range(len(columns))]


def _rotate(
    tape: Tape, upper: list[Node], lower: list[Node], j: int
) -> tuple[list[Node], list[Node]]:
    """Turn two rows so that the lower one's entry j vanishes."""
    a, b = upper[j], lower[j]
    if a == tape.zero:
        return lower, upper
    radius = tape.unary("sqrt", tape.add(tape.mul(a, a), tape.mul(b, b)))
    # Both entries may vanish at a single state: the tiny term keeps that state finite.
    radius = tape.add(radius, tape.constant(1e-300))
    c, s = tape.div(a, radius), tape.div(b, radius)
    turned = [tape.add(tape.mul(c, x), tape.mul(s, y)) for x, y in zip(upper, lower, strict=True)]
    rest = [tape.sub(tape.mul(c, y), tape.mul(s, x)) for x, y in zip(upper, lower, strict=True)]
    rest[j] = tape.zero
    return turned, rest


def _back_substitute(tape: Tape, rows: Matrix, size: int, column: int) -> list[Node]:
    solution = [tape.zero] * size
    for i in reversed(range(size)):
        known = tape.dot(rows[i][i + 1 : size], solution[i + 1 :])
        solution[i] = tape.div(tape.sub(rows[i][column], known), rows[i][i])
    return solution
