"""What cancels against plain numbers, and against what turns there and back must give."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given, settings

from kinolab.dynamics.derivation.cancellation import Cancellation
from kinolab.dynamics.derivation.expression_graph import ExpressionGraph
from tests.dynamics.derivation.test_expression_graph import LABELS, build, expressions, states


@pytest.mark.parametrize("anew", [False, True])
@settings(deadline=None)
@given(tree=expressions, values=states)
def test_rewritten_expressions_have_the_same_value(
    anew: bool, tree: Any, values: tuple[float, ...]
) -> None:
    tape = ExpressionGraph()
    node = build(tape, tree)
    (short,) = Cancellation(tape, anew=anew).rewritten([node])
    point = dict(zip(LABELS, values, strict=True))
    before, after = tape.evaluate([node, short], point)
    assert after == pytest.approx(before, rel=1e-9, abs=1e-9)


def turned(tape: ExpressionGraph, x: int, y: int, angle: int) -> tuple[int, int]:
    c, s = tape.unary("cos", angle), tape.unary("sin", angle)
    return tape.sub(tape.mul(c, x), tape.mul(s, y)), tape.add(tape.mul(s, x), tape.mul(c, y))


def test_a_turn_there_and_back_is_none() -> None:
    tape = ExpressionGraph()
    x, y, a, b = (tape.variable(name) for name in "xyab")
    there = turned(tape, *turned(tape, x, y, a), b)
    back = turned(tape, *turned(tape, *there, tape.neg(b)), tape.neg(a))
    assert tuple(Cancellation(tape).rewritten(back)) == (x, y)


def test_sums_of_squares_are_found_below_other_terms() -> None:
    tape = ExpressionGraph()
    a, m = tape.variable("a"), tape.variable("m")
    c, s = tape.unary("cos", a), tape.unary("sin", a)
    one = tape.mul(m, tape.mul(c, c))
    other = tape.mul(tape.mul(s, m), tape.mul(s, tape.constant(1.0)))
    assert Cancellation(tape).rewritten([tape.add(one, other)]) == [m]


def test_sums_and_quotients_are_written_anew_where_something_cancels() -> None:
    tape = ExpressionGraph()
    a, b, r = (tape.variable(name) for name in "abr")
    c, s = tape.unary("cos", a), tape.unary("sin", a)
    half = tape.mul(tape.constant(0.5), tape.mul(b, r))
    one, other = (tape.div(tape.mul(wave, half), b) for wave in (c, s))
    squares = tape.add(tape.mul(c, one), tape.mul(s, other))  # r / 2: b cancels
    total = tape.add(tape.sub(a, squares), tape.add(squares, b))
    found = Cancellation(tape, anew=True).rewritten([squares, total])
    assert found == [tape.mul(tape.constant(0.5), r), tape.add(a, b)]


def test_what_is_nearly_zero_is_not_called_zero() -> None:
    tape = ExpressionGraph()
    x = tape.variable("x")
    tiny = tape.sub(tape.mul(tape.constant(1.0 + 1e-9), x), x)
    (short,) = Cancellation(tape).rewritten([tiny])
    assert tape.evaluate([short], {"x": 1.0})[0] == pytest.approx(1e-9, rel=1e-6)


def test_many_terms_take_no_time() -> None:
    tape = ExpressionGraph()
    total = tape.one
    for k in range(40):
        angle = tape.variable(f"a{k}")
        total = tape.mul(total, tape.add(tape.unary("sin", angle), tape.unary("cos", angle)))
    (short,) = Cancellation(tape).rewritten([total])
    point = {f"a{k}": 0.1 * k for k in range(40)}
    expected = math.prod(math.sin(0.1 * k) + math.cos(0.1 * k) for k in range(40))
    assert tape.evaluate([short], point)[0] == pytest.approx(expected, rel=1e-9)
