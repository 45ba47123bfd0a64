"""Linear systems on the tape against LAPACK, and guards against singular ones."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from kinolab.dynamics.derivation.expression_graph import ExpressionGraph
from kinolab.dynamics.derivation.symbolic_solve import Guards, solve_definite, solve_square

Array = NDArray[np.float64]
SIZES = range(1, 8)


def solved(solver: Any, A: Array, B: Array, structure: Array | None = None) -> tuple[Array, Array]:
    """Solution and guards, the entries being variables; where ``structure`` is 0, constants 0."""
    tape, guards = ExpressionGraph(), Guards()
    known = np.ones_like(A) if structure is None else structure
    nodes = [
        [
            tape.variable(f"a{min(i, j)}_{max(i, j)}_{i > j}") if known[i, j] else tape.zero
            for j in range(len(A))
        ]
        for i in range(len(A))
    ]
    columns = [[tape.variable(f"b{i}_{k}") for i in range(len(A))] for k in range(B.shape[1])]
    made = solver(tape, nodes, columns, guards)
    values = {
        f"a{min(i, j)}_{max(i, j)}_{i > j}": A[i, j] for i in range(len(A)) for j in range(len(A))
    }
    values |= {f"b{i}_{k}": B[i, k] for i in range(len(A)) for k in range(B.shape[1])}
    found = [tape.evaluate(column, values) for column in made]
    return np.array(found).T, np.array(tape.evaluate(guards.nodes, values))


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("seed", range(4))
def test_definite_systems_are_solved_as_lapack_does(size: int, seed: int) -> None:
    rng = np.random.default_rng([size, seed])
    L = rng.normal(size=(size, size))
    M = L @ L.T + 0.1 * np.eye(size)
    B = rng.normal(size=(size, 2))
    X, guards = solved(solve_definite, M, B)
    tolerance = 1e-15 * 50 * np.linalg.cond(M)  # relative to the solution: rounding times condition
    np.testing.assert_allclose(X, np.linalg.solve(M, B), rtol=0, atol=tolerance * np.abs(X).max())
    assert (guards > 0).all()


@pytest.mark.parametrize("size", [3, 9])  # differentiated through the factors, and as equations
def test_solutions_of_definite_systems_have_the_derivative_of_their_equations(size: int) -> None:
    rng = np.random.default_rng(size)
    L, slope = rng.normal(size=(size, size)), rng.normal(size=(size, size))
    M, b, b_dot = L @ L.T + np.eye(size), rng.normal(size=size), rng.normal(size=size)
    slope += slope.T
    slope[0, 1:] = slope[1:, 0] = 0.0
    M[0, 1:] = M[1:, 0] = 0.0  # an unknown of its own
    tape = ExpressionGraph()
    t, dt = tape.variable("t"), tape.variable("dt")

    def line(value: float, rate: float) -> int:
        """M and b at t: value + rate t."""
        return tape.add(tape.constant(value), tape.mul(tape.constant(rate), t))

    nodes = [[line(M[i, j], slope[i, j]) for j in range(size)] for i in range(size)]
    (x,) = solve_definite(tape, nodes, [[*map(line, b, b_dot)]], Guards())
    twice = tape.mul(x[-1], x[0])  # what rests on a solution
    tangents = tape.derivative([*x, twice], {t: dt})
    found = tape.evaluate(tangents, {"t": 0.0, "dt": 0.5})
    solution = np.linalg.solve(M, b)
    expected = 0.5 * np.linalg.solve(M, b_dot - slope @ solution)
    product = expected[-1] * solution[0] + solution[-1] * expected[0]
    np.testing.assert_allclose(found, [*expected, product], rtol=1e-11)


def test_solutions_that_are_part_of_their_equations_are_differentiated_too() -> None:
    """x_i = b_i where M is 1: its tangent is that of b_i, and asks for none of x."""
    size = 9
    M = np.eye(size)
    M[0, 1] = M[1, 0] = 0.3
    tape = ExpressionGraph()
    nodes = [[tape.constant(entry) for entry in row] for row in M]
    b = [tape.variable(f"b{i}") for i in range(size)]
    b[2] = tape.unary("sin", b[3])
    (x,) = solve_definite(tape, nodes, [b], Guards())
    (y,) = solve_definite(tape, nodes, [[*x[1:], x[0]]], Guards())  # what rests on a solution
    values = {f"b{i}": 0.1 * (i + 1) for i in range(size)}
    seeds = {tape.variable(name): tape.constant(value) for name, value in values.items()}
    rates = np.array([*values.values()])
    rates[2] = np.cos(values["b3"]) * values["b3"]
    inverse = np.linalg.inv(M)
    found = tape.evaluate(tape.derivative([*x, *y], seeds), values)
    expected = [*inverse @ rates, *inverse @ np.roll(inverse @ rates, -1)]
    np.testing.assert_allclose(found, expected, rtol=1e-13)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kind", ["full", "sparse", "zero leading", "permuted"])
def test_square_systems_are_solved_as_lapack_does(size: int, seed: int, kind: str) -> None:
    rng = np.random.default_rng([size, seed, 1])
    A = rng.normal(size=(size, size))
    structure = np.ones_like(A)
    if kind == "sparse":
        structure = (rng.random((size, size)) < 0.4).astype(float)
        structure[np.arange(size), rng.permutation(size)] = 1.0  # keeps the determinant alive
        A = structure * A
    if kind == "zero leading":
        A[0, 0] = A[-1, 0] = 0.0 if size > 2 else A[-1, 0]
        A[0, 0] = 0.0 if size > 1 else A[0, 0]
        structure = np.where(rng.random((size, size)) < 0.5, A != 0, 1.0)
    if kind == "permuted":
        structure = np.eye(size)[rng.permutation(size)]
        A = structure * A
    if np.linalg.cond(A) > 1e6:
        pytest.skip("this draw is singular")
    B = rng.normal(size=(size, 3))
    X, guards = solved(solve_square, A, B, structure)
    expected = np.linalg.solve(A, B)
    tolerance = 1e-15 * 200 * np.linalg.cond(A)  # rounding times condition; cofactors lose a bit
    np.testing.assert_allclose(X, expected, rtol=0, atol=tolerance * np.abs(expected).max())
    assert (guards > 0).all()


@pytest.mark.parametrize("size", SIZES)
def test_a_singular_square_matrix_leaves_a_guard_that_is_not_positive(size: int) -> None:
    rng = np.random.default_rng(size)
    A = rng.normal(size=(size, size))
    A[-1] = 0.5 * A[:-1].sum(axis=0)  # for size 1 this is 0
    assert not (solved_guards(solve_square, A) > 0).all()


@pytest.mark.parametrize("size", range(2, 8))
def test_a_square_matrix_with_a_vanished_column_leaves_a_guard(size: int) -> None:
    A = np.random.default_rng(size).normal(size=(size, size))
    A[:, size // 2] = 0.0
    assert not (solved_guards(solve_square, A) > 0).all()


@pytest.mark.parametrize("size", range(2, 8))
@pytest.mark.parametrize("seed", range(3))
def test_entries_that_are_zero_at_one_state_only_do_not_spoil_a_regular_matrix(
    size: int, seed: int
) -> None:
    """A permutation among variables that happen to be 0: as regular as a matrix can be."""
    rng = np.random.default_rng([size, seed])
    A = np.eye(size)[rng.permutation(size)]
    B = rng.normal(size=(size, 1))
    X, guards = solved(solve_square, A, B)
    np.testing.assert_allclose(X, A.T @ B, atol=1e-14)
    assert (guards > 0).all()


def test_a_square_matrix_whose_first_column_vanishes_is_guarded_also_by_rotations() -> None:
    """Both entries of a rotation vanish there; a NaN must not hide it."""
    A = np.random.default_rng(0).normal(size=(5, 5))
    A[:, 0] = 0.0
    assert not (solved_guards(solve_square, A) > 0).all()


@pytest.mark.parametrize("size", range(2, 8))
@pytest.mark.parametrize("share", [0.0, -1e-3, -1.0])
def test_a_matrix_that_is_not_definite_leaves_a_guard(size: int, share: float) -> None:
    rng = np.random.default_rng(size)
    Q = np.linalg.qr(rng.normal(size=(size, size)))[0]
    M = Q @ np.diag([*rng.uniform(1, 2, size - 1), share]) @ Q.T
    assert not (solved_guards(solve_definite, M) > 0).all()


@pytest.mark.parametrize("share", [0.0, -1.0])
def test_a_mass_that_is_not_positive_leaves_a_guard(share: float) -> None:
    assert not (solved_guards(solve_definite, np.array([[share]])) > 0).all()


def solved_guards(solver: Any, A: Array) -> Array:
    """Guards alone: the solution may divide by zero."""
    tape, guards = ExpressionGraph(), Guards()
    size = len(A)
    nodes = [[tape.variable(f"a{i}_{j}") for j in range(size)] for i in range(size)]
    if solver is solve_definite:
        nodes = [[nodes[max(i, j)][min(i, j)] for j in range(size)] for i in range(size)]
    solver(tape, nodes, [[tape.one] * size], guards)
    values = {f"a{i}_{j}": float(A[i, j]) for i in range(size) for j in range(size)}
    results = []
    for node in guards.nodes:
        try:
            results += tape.evaluate([node], values)
        except ZeroDivisionError:  # compiled code gets a NaN here, which is not positive either
            results.append(np.nan)
    return np.array(results)


def test_a_structurally_singular_matrix_is_refused_at_once() -> None:
    tape = ExpressionGraph()
    x = tape.variable("x")
    with pytest.raises(ZeroDivisionError, match="do not determine"):
        solve_square(tape, [[x, tape.zero], [x, tape.zero]], [[x, x]], Guards())


def test_a_positive_constant_needs_no_guard() -> None:
    tape, guards = ExpressionGraph(), Guards()
    solve_definite(tape, [[tape.constant(2.0)]], [[tape.one]], guards)
    solve_square(tape, [[tape.constant(-3.0)]], [[tape.one]], guards)
    assert guards.nodes == []


def test_nothing_to_solve_has_an_empty_solution() -> None:
    tape = ExpressionGraph()
    assert solve_square(tape, [], [[], []], Guards()) == [[], []]
    assert solve_definite(tape, [], [[]], Guards()) == [[]]
