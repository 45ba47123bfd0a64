"""Serialization of SymPy expressions as plain trees: ``["mul", "m", ["pow", "R", 2]]``, m R^2.

A string is a symbol, a number a number, a list an operation from a fixed table. Reading calls only
constructors from that table. A path of many corners is one operation: ``["hinges", "time", rows]``
is the sum of k max(time - c, 0) over packed rows of c and k.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import sympy

from kinolab.dynamics.language.shapes.packed_rows import packed, unpacked
from kinolab.dynamics.symbols.expressions import exact
from kinolab.errors import InputError, Mistake

OPERATIONS: dict[str, type] = {
    "add": sympy.Add,
    "mul": sympy.Mul,
    "pow": sympy.Pow,
    "sin": sympy.sin,
    "cos": sympy.cos,
    "tan": sympy.tan,
    "exp": sympy.exp,
    "log": sympy.log,
    "tanh": sympy.tanh,
    "atan": sympy.atan,
    "abs": sympy.Abs,
    "sign": sympy.sign,
    "max": sympy.Max,
}
CONSTANTS: dict[str, Any] = {"pi": sympy.pi, "E": sympy.E}
HINGES = "hinges"
NOTHING_NAMED: Mapping[sympy.Basic, str] = {}


def expression_to_tree(expression: Any, named: Mapping[sympy.Basic, str] = NOTHING_NAMED) -> Any:
    """Return an expression as nested lists of names and numbers.

    Args:
        expression: The expression, or a number.
        named: Names that stand for parts of it.

    Raises:
        InputError: If it has a function outside the table.
    """
    expression = exact(expression)
    if expression in named:
        return named[expression]
    if expression.is_Symbol:
        return expression.name
    if expression.is_Integer:
        return int(expression)
    if expression.is_Float:
        return float(expression)
    if expression.is_Rational:
        return ["ratio", int(expression.p), int(expression.q)]
    if expression.is_Add and (hinges := _hinges(expression)):
        rest = [expression_to_tree(a, named) for a in expression.args if a not in hinges]
        return ["add", *rest, *_packed_hinges(hinges)]
    for name, value in CONSTANTS.items():
        if expression == value:
            return [name]
    for name, kind in OPERATIONS.items():
        if expression.func is kind:
            return [name, *(expression_to_tree(argument, named) for argument in expression.args)]
    what = f"{expression.func.__name__} cannot be written to a machine file."
    names = [name for name, kind in OPERATIONS.items() if issubclass(kind, sympy.Function)]
    remedy = f"Write it with sums, products, powers, max, {', '.join(names)}."
    raise InputError([Mistake(str(expression), what, remedy)])


def _hinge(symbol: sympy.Symbol, at: float, kink: float) -> sympy.Expr:
    """Return kink max(symbol - at, 0), of which nothing is compared: that takes a millisecond."""
    return sympy.Float(kink) * sympy.Max(symbol - sympy.Float(at), 0, evaluate=False)


def _hinges(total: sympy.Add) -> dict[sympy.Expr, tuple[sympy.Symbol, float, float]]:
    """Return symbol, place and kink of the terms that ``_hinge`` makes, where they are several."""
    found = {}
    for term in total.args:
        kink, rest = term.as_coeff_Mul()
        inner = [a for a in rest.args if not a.is_zero] if isinstance(rest, sympy.Max) else []
        if len(inner) == 1:
            less, symbol = inner[0].as_coeff_Add()
            if symbol.is_Symbol and _hinge(symbol, -float(less), float(kink)) == term:
                found[term] = (symbol, -float(less), float(kink))
    return found if len(found) > 1 else {}


def _packed_hinges(
    hinges: Mapping[sympy.Expr, tuple[sympy.Symbol, float, float]],
) -> list[list[str]]:
    rows: dict[str, list[tuple[float, float]]] = {}
    for symbol, at, kink in hinges.values():
        rows.setdefault(symbol.name, []).append((at, kink))
    return [[HINGES, name, packed(sorted(some), "<f8")] for name, some in rows.items()]


def expanded_size(expressions: Iterable[sympy.Expr]) -> int:
    """Return the number of names, numbers and operations if nothing is written only once."""
    known: dict[sympy.Basic, int] = {}

    def size(part: sympy.Basic) -> int:
        if part not in known:
            known[part] = 1 + sum(map(size, part.args))
        return known[part]

    return sum(map(size, expressions))


def tree_to_expression(tree: Any, symbols: Mapping[str, sympy.Symbol], depth: int = 0) -> Any:
    """Return the expression of a tree.

    Raises:
        ValueError: If it has an unknown name or operation, or is nested too deeply.
    """
    if depth > 200:  # of nesting; Python's stack overflows at about five times that
        raise ValueError("an expression is nested too deeply")
    match tree:
        case bool() | None:
            raise ValueError(f"{tree!r} is no expression")
        case int():
            return _real(sympy.Integer(tree))
        case float():
            return _real(sympy.Float(tree))
        case str():
            if tree not in symbols:
                raise ValueError(f"unknown symbol {tree!r}")
            return symbols[tree]
        case ["ratio", int(p), int(q)] if q != 0:
            return _real(sympy.Rational(p, q))
        case [str(name)] if name in CONSTANTS:
            return CONSTANTS[name]
        case ["hinges", str(name), str(text)] if name in symbols:
            rows = unpacked(text, "<f8", columns=2)
            if not np.isfinite(rows).all():
                raise ValueError("a path has a corner that is not finite")
            return sympy.Add(*(_hinge(symbols[name], *row) for row in rows.tolist()))
        case [str(name), *rest] if name in OPERATIONS and rest:
            arguments = [tree_to_expression(entry, symbols, depth + 1) for entry in rest]
            _check_cost(name, arguments)
            return _real(OPERATIONS[name](*arguments))
    raise ValueError(f"{str(tree)[:60]} is no expression")


def _real(made: Any) -> Any:
    """Reject what is no finite real number in double range: 1/0, sqrt(-1), NaN, 10^400."""
    # 1024 bits of numerators and denominators, which doubles do not reach either
    if made.is_Rational and max(made.p.bit_length(), made.q.bit_length()) > 1024:
        raise ValueError("a number has too many digits")
    # Asked of numbers alone: for a long expression SymPy takes long to tell.
    if made.is_number and (
        made is sympy.nan
        or made.is_finite is False
        or made.is_real is False
        or (made.is_Float and not math.isfinite(float(made)))
    ):
        raise ValueError(f"{made} is no finite real number")
    return made


def _check_cost(name: str, arguments: list[Any]) -> None:
    """Reject what SymPy would work on for hours when it is built.

    That are towers such as 9**9**9, which it computes exactly, a product of many roots, of which it
    looks for common factors, and a maximum of many terms, of which it compares each with each.
    """
    if name == "max":
        if sum(len(a.args) if isinstance(a, sympy.Max) else 1 for a in arguments) > 8:
            raise ValueError("a maximum has more than 8 terms")
    elif name == "mul":
        factors = [f for a in arguments for f in sympy.Mul.make_args(a)]
        if sum(f.is_number and not (f.is_Rational or f.is_Float) for f in factors) > 8:
            raise ValueError("a product has more than 8 irrational numbers")
    elif name in ("exp", "pow") and all(argument.is_number for argument in arguments):
        powers = arguments if name == "pow" else [sympy.E, *arguments]
        base, exponent = (abs(float(argument)) for argument in powers)
        # 300 digits of a power of numbers, near the range of a double
        if exponent * abs(math.log10(base or 1.0)) > 300:
            raise ValueError("a power is too large")
