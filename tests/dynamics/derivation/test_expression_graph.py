"""The tape against plain Python floats and central differences."""

import math
import operator
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinolab.dynamics.derivation.expression_graph import UNARY, ExpressionGraph

LABELS = ("x", "y", "z")
SMOOTH = ("sin", "cos", "tanh", "atan")
CONSTANTS = (0.0, 1.0, -1.0, 2.0, -0.5, 3.25)

# An expression is data: a label, a number, or (operator, operand, ...).
leaves = st.sampled_from(LABELS) | st.sampled_from(CONSTANTS)


def branches(inner: Any) -> Any:
    """Expressions of any shape that have a finite, moderate value everywhere."""
    return (
        st.tuples(st.sampled_from(("add", "sub", "mul")), inner, inner)
        | st.tuples(st.sampled_from((*SMOOTH, "neg")), inner)
        | st.tuples(st.just("over"), inner, inner)  # a / (2 + sin b)
        | st.tuples(st.just("root"), inner)  # sqrt(1 + a^2)
        | st.tuples(st.just("log"), inner)  # log(1 + a^2)
        | st.tuples(st.just("exp"), inner)  # exp(tanh a)
        | st.tuples(st.just("cube"), inner)  # a^3 of a sine
        | st.tuples(st.just("minus1.5"), inner)  # (1 + a^2)^-1.5
        | st.tuples(st.just("power.3"), inner)  # (1 + a^2)^0.3
    )


expressions = st.recursive(leaves, branches, max_leaves=12)
states = st.tuples(*[st.floats(-2, 2).map(lambda v: round(v, 3) + 1e-4)] * 3)


def build(tape: ExpressionGraph, tree: Any) -> int:
    if isinstance(tree, str):
        return tape.variable(tree)
    if isinstance(tree, float):
        return tape.constant(tree)
    name, *rest = tree
    a, *more = [build(tape, entry) for entry in rest]
    square = tape.add(tape.one, tape.mul(a, a))
    table: dict[str, Callable[[], int]] = {
        "neg": lambda: tape.neg(a),
        "over": lambda: tape.div(a, tape.add(tape.constant(2.0), tape.unary("sin", more[0]))),
        "root": lambda: tape.unary("sqrt", square),
        "log": lambda: tape.unary("log", square),
        "exp": lambda: tape.unary("exp", tape.unary("tanh", a)),
        "cube": lambda: tape.power(tape.unary("sin", a), 3),
        "minus1.5": lambda: tape.power(square, -1.5),
        "power.3": lambda: tape.power(square, 0.3),
    }
    if name in table:
        return table[name]()
    if name in SMOOTH:
        return tape.unary(name, a)
    made: int = getattr(tape, name)(a, *more)
    return made


def python(tree: Any, values: dict[str, float]) -> float:
    if isinstance(tree, str):
        return values[tree]
    if isinstance(tree, float):
        return tree
    name, *rest = tree
    return MEANING[name](*[python(entry, values) for entry in rest])


MEANING: dict[str, Callable[..., float]] = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "neg": operator.neg,
    "over": lambda a, b: a / (2 + math.sin(b)),
    "root": lambda a: math.sqrt(1 + a * a),
    "log": lambda a: math.log(1 + a * a),
    "exp": lambda a: math.exp(math.tanh(a)),
    "cube": lambda a: math.sin(a) ** 3,
    "minus1.5": lambda a: float((1 + a * a) ** -1.5),
    "power.3": lambda a: float((1 + a * a) ** 0.3),
    **{name: getattr(math, name) for name in SMOOTH},
}


def size(tree: Any, values: dict[str, float]) -> float:
    """The largest intermediate magnitude: rounding errors are a share of it."""
    own = abs(python(tree, values))
    return max([own, 1.0, *(size(t, values) for t in tree[1:])]) if isinstance(tree, tuple) else own


@given(expressions, states)
@settings(max_examples=200, deadline=None)
def test_folding_and_sharing_keep_every_value(tree: Any, state: Any) -> None:
    values = dict(zip(LABELS, state, strict=True))
    tape = ExpressionGraph()
    node = build(tape, tree)
    # Reordered sums lose a few units in the 16th digit of the largest intermediate value.
    tolerance = 1e-11 * size(tree, values) ** 2
    assert tape.evaluate([node], values)[0] == pytest.approx(
        python(tree, values), rel=1e-11, abs=tolerance
    )


@given(expressions, states, states)
@settings(max_examples=150, deadline=None)
def test_a_derivative_is_the_limit_of_central_differences(
    tree: Any, state: Any, direction: Any
) -> None:
    tape = ExpressionGraph()
    node = build(tape, tree)
    seeds = {tape.variable(n): tape.constant(d) for n, d in zip(LABELS, direction, strict=True)}
    (made,) = tape.derivative([node], seeds)
    values = dict(zip(LABELS, state, strict=True))

    def along(s: float) -> float:
        moved = (v + s * d for v, d in zip(state, direction, strict=True))
        return python(tree, dict(zip(LABELS, moved, strict=True)))

    coarse, fine = ((along(h) - along(-h)) / (2 * h) for h in (2e-3, 1e-3))
    expected = fine + (fine - coarse) / 3  # Richardson: the error is O(h^4)
    slack = 0.05 * abs(fine - coarse) + 1e-9 * size(tree, values)
    assert tape.evaluate([made], values)[0] == pytest.approx(expected, rel=1e-7, abs=slack)


@given(expressions, expressions, states)
@settings(max_examples=100, deadline=None)
def test_substituting_an_expression_is_evaluating_it_first(
    outer: Any, inner: Any, state: Any
) -> None:
    values = dict(zip(LABELS, state, strict=True))
    tape = ExpressionGraph()
    nodes = {tape.variable("x"): build(tape, inner)}
    (made,) = tape.substitute([build(tape, outer)], nodes)
    moved = values | {"x": python(inner, values)}
    tolerance = 1e-10 * max(size(outer, moved), size(inner, values)) ** 2
    assert tape.evaluate([made], values)[0] == pytest.approx(
        python(outer, moved), rel=1e-10, abs=tolerance
    )


def test_substitution_swaps_two_variables_at_once() -> None:
    tape = ExpressionGraph()
    x, y = tape.variable("x"), tape.variable("y")
    (made,) = tape.substitute([tape.sub(x, tape.mul(y, y))], {x: y, y: x})
    assert tape.evaluate([made], {"x": 3.0, "y": 5.0}) == [5.0 - 9.0]


def test_equal_expressions_are_one_node() -> None:
    tape = ExpressionGraph()
    x, y = tape.variable("x"), tape.variable("y")
    assert tape.add(x, y) == tape.add(y, x)
    assert tape.mul(x, y) == tape.mul(y, x)
    assert tape.sub(x, y) != tape.sub(y, x)
    assert tape.neg(tape.sub(x, y)) == tape.sub(y, x)
    assert tape.mul(tape.neg(x), tape.neg(y)) == tape.mul(x, y)
    assert tape.unary("sin", tape.neg(x)) == tape.neg(tape.unary("sin", x))
    assert tape.unary("cos", tape.neg(x)) == tape.unary("cos", x)
    assert tape.add(x, tape.neg(x)) == tape.zero


@pytest.mark.parametrize("swap", [False, True])
def test_the_squares_of_sine_and_cosine_of_one_angle_make_1(swap: bool) -> None:
    tape = ExpressionGraph()
    x, y = tape.variable("x"), tape.variable("y")
    square = [tape.power(tape.unary(name, x), 2) for name in ("sin", "cos")]
    assert tape.add(*(reversed(square) if swap else square)) == tape.one
    other = tape.power(tape.unary("cos", y), 2)
    assert tape.value(tape.add(square[0], other)) is None
    assert tape.value(tape.add(square[0], square[0])) is None
    mixed = tape.mul(tape.unary("cos", x), tape.unary("cos", y))
    assert tape.value(tape.add(square[0], mixed)) is None


def test_dividing_by_the_constant_zero_is_an_error() -> None:
    tape = ExpressionGraph()
    with pytest.raises(ZeroDivisionError, match="an expression divides by zero"):
        tape.div(tape.variable("x"), tape.zero)
    with pytest.raises(ZeroDivisionError):
        tape.power(tape.zero, -1)


def test_a_maximum_moves_as_the_larger_one_does() -> None:
    tape = ExpressionGraph()
    x, y = tape.variable("x"), tape.variable("y")
    node = tape.maximum(x, y)
    (slope,) = tape.derivative([node], {x: tape.constant(2.0), y: tape.constant(5.0)})
    assert tape.evaluate([node, slope], {"x": 2.0, "y": 3.0}) == [3.0, 5.0]
    assert tape.evaluate([node, slope], {"x": 4.0, "y": 3.0}) == [4.0, 2.0]
    assert tape.evaluate([slope], {"x": 3.0, "y": 3.0}) == [3.5]  # between both
    z = tape.variable("z")
    assert tape.derivative([node], {z: tape.one}) == [tape.zero]  # it does not move along z


@pytest.mark.parametrize(
    "exponent", [0, 1, 2, 3, 7, 0.5, 1.5, 2.5, 1 / 3, -1, -2, -0.5, -1 / 3, 9.1]
)
def test_powers_are_powers(exponent: float) -> None:
    tape = ExpressionGraph()
    node = tape.power(tape.variable("x"), exponent)
    for x in (0.3, 1.0, 4.7):
        assert tape.evaluate([node], {"x": x})[0] == pytest.approx(x**exponent, rel=1e-13)


@pytest.mark.parametrize("exponent", [3, -3, 2, -2])
def test_whole_powers_take_negative_numbers(exponent: int) -> None:
    tape = ExpressionGraph()
    node = tape.power(tape.variable("x"), exponent)
    assert tape.evaluate([node], {"x": -1.7})[0] == pytest.approx((-1.7) ** exponent, rel=1e-14)


@pytest.mark.parametrize("name", sorted(UNARY))
def test_every_function_has_a_derivative(name: str) -> None:
    tape = ExpressionGraph()
    x = tape.variable("x")
    (slope,) = tape.derivative([tape.unary(name, x)], {x: tape.one})
    for at in (0.4, 1.1):
        h = 1e-5
        expected = (UNARY[name](at + h) - UNARY[name](at - h)) / (2 * h)
        assert tape.evaluate([slope], {"x": at})[0] == pytest.approx(expected, rel=1e-8)


def test_operands_come_before_what_rests_on_them() -> None:
    tape = ExpressionGraph()
    x = tape.variable("x")
    node = tape.div(tape.unary("sin", tape.add(x, tape.one)), tape.unary("cos", x))
    seen: set[int] = set()
    for needed in tape.needed([node]):
        assert set(tape.operations[needed].operands) <= seen
        seen.add(needed)
    assert tape.depends_on(node) == {x}


def test_a_long_chain_needs_no_deep_recursion() -> None:
    tape = ExpressionGraph()
    x = node = tape.variable("x")
    for _ in range(5000):
        node = tape.unary("sin", tape.add(node, x))
    assert tape.depends_on(node) == {x}
    (slope,) = tape.derivative([node], {x: tape.one})
    assert math.isfinite(tape.evaluate([slope], {"x": 0.1})[0])


def test_the_root_of_a_long_sum_needs_no_deep_recursion() -> None:
    """The length of a vector of 5000 entries, along the diagonal."""
    tape = ExpressionGraph()
    x = [tape.variable(f"x{i}") for i in range(5000)]
    length = tape.unary("sqrt", tape.sum(tape.mul(one, one) for one in x))
    (slope,) = tape.derivative([length], dict.fromkeys(x, tape.one))
    values = {f"x{i}": 1.0 + i for i in range(len(x))}
    size = math.sqrt(math.fsum(v * v for v in values.values()))
    expected = math.fsum(values.values()) / size
    assert tape.evaluate([slope], values) == pytest.approx([expected], rel=1e-12)


def test_the_root_of_sums_of_sums_is_differentiated_in_few_operations() -> None:
    """sqrt(F_n x^2 + F_(n+1) y^2) by Fibonacci's sums: as a tree it would have F_100 terms."""
    tape = ExpressionGraph()
    x, y = tape.variable("x"), tape.variable("y")
    terms, counts = (tape.mul(x, x), tape.mul(y, y)), (1, 1)
    for _ in range(100):
        terms = terms[1], tape.add(*terms)
        counts = counts[1], sum(counts)
    (slope,) = tape.derivative([tape.unary("sqrt", terms[1])], {x: tape.one, y: tape.one})
    expected = math.sqrt(counts[1])  # at x = y = 1
    assert tape.evaluate([slope], {"x": 1.0, "y": 1.0}) == pytest.approx([expected], rel=1e-12)
