"""Formulas that users write as text, in the words of a machine; no text is ever run as code."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import sympy

from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.frames import pose, time_derivative
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import (
    configuration_symbols,
    quasi_velocities,
    tangent_symbols,
)
from kinolab.dynamics.language.modes import MODE
from kinolab.errors import InputError, Mistake, unknown_name


def _power(base: sympy.Expr, exponent: sympy.Expr) -> sympy.Expr:
    """Return a power; of two numbers as a float, since exact ones may have any number of digits."""
    if base.is_number and exponent.is_number:
        return sympy.Float(float(base) ** float(exponent))
    return base**exponent


OPERATORS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: _power,
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
}
FUNCTIONS: dict[str, Callable[..., Any]] = {
    "abs": sympy.Abs,
    "atan": sympy.atan,
    "cos": sympy.cos,
    "exp": sympy.exp,
    "log": sympy.log,
    "max": sympy.Max,
    "sin": sympy.sin,
    "sqrt": sympy.sqrt,
    "tan": sympy.tan,
    "tanh": sympy.tanh,
}
CONSTANTS = {"pi": sympy.pi}
AXES = "xyz"
LONGEST = 2000  # characters of a formula: longer ones nest deeper than Python's parser allows


def formula(text: str, system: Mechanism, where: str) -> sympy.Expr:
    """Return the expression that a text stands for.

    Args:
        text: Such as ``"theta**2 + 0.1 * motor**2"``: numbers, the four operations and powers,
            functions such as ``sin``, and the names of coordinates, rates, states, inputs and
            parameters; ``hook.x`` is where the body hook's origin is in the world in [m],
            ``hook.vx`` how fast it moves along the world's x axis in [m/s].
        where: Where the text stands, for errors.

    Raises:
        InputError: If it is no formula, or has a name that the machine has not.
    """
    own = [
        *configuration_symbols(system),
        *tangent_symbols(system),
        *(entry.symbol for entry in quasi_velocities(system)),
        *(entry.symbol for entry in system.states if entry.name != MODE),
        *(entry.symbol for entry in system.inputs),
        *system.parameters,
    ]
    return formula_in(text, {str(s.name): s for s in own}, where, system.bodies)


def formula_in(
    text: str, names: Mapping[str, sympy.Expr], where: str, bodies: Sequence[Body] = ()
) -> sympy.Expr:
    """Return the expression that a text stands for, as ``formula``.

    Args:
        text: Such as ``"2 * sin(t)"``.
        names: What its names stand for, beside ``pi``.
        where: Where the text stands, for errors.
        bodies: Whose places and speeds may be in it.

    Raises:
        InputError: If it is no formula, or has a name that is not among these.
    """
    try:
        if len(text) > LONGEST:
            raise _NoFormulaError(f"it has more than {LONGEST} characters")
        tree = ast.parse(text.strip(), mode="eval").body
        return sympy.sympify(_Reader(names, bodies, where).read(tree))
    except (SyntaxError, ValueError, TypeError, ArithmeticError, RecursionError, MemoryError):
        reason = "it cannot be read"
    except _NoFormulaError as error:
        reason = str(error)
    remedy = 'Write numbers, names of the machine, + - * / ** and functions: "theta**2 + sin(x)".'
    raise InputError([Mistake(where, f"{text[:80]!r} is no formula: {reason}.", remedy)])


class _NoFormulaError(Exception):
    """What was written is no formula; the message says why."""


class _Reader:
    def __init__(self, names: Mapping[str, sympy.Expr], bodies: Sequence[Body], where: str) -> None:
        self._where, self._bodies = where, {body.name: body for body in bodies}
        self._names = {**CONSTANTS, **names}

    def read(self, node: ast.expr) -> sympy.Expr:
        """Return the expression of a node of Python's grammar."""
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            return sympy.sympify(node.value)
        if isinstance(node, ast.Name):
            return self._known(node.id, self._names)
        if isinstance(node, ast.BinOp | ast.UnaryOp) and type(node.op) in OPERATORS:
            operands = (node.left, node.right) if isinstance(node, ast.BinOp) else (node.operand,)
            return OPERATORS[type(node.op)](*map(self.read, operands))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
            function = self._known(node.func.id, FUNCTIONS)
            arguments = list(map(self.read, node.args))
            if len(arguments) != 1 and function is not sympy.Max:
                raise _NoFormulaError(f"{node.func.id} takes one argument")
            return function(*arguments)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            return self._of_body(node.value.id, node.attr)
        raise _NoFormulaError(f"{ast.unparse(node)[:40]!r} is none of what may be written")

    def _of_body(self, name: str, entry: str) -> sympy.Expr:
        """Return a coordinate of a body's origin, or how fast that changes."""
        frame = self._known(name, self._bodies).frame
        if len(entry) == 1 and entry in AXES:
            return pose(frame)[1][AXES.index(entry)]
        if len(entry) == 2 and entry[0] == "v" and entry[1] in AXES:
            return time_derivative(pose(frame)[1][AXES.index(entry[1])])
        raise _NoFormulaError(f"a body has x, y, z, vx, vy and vz, and not {entry!r}")

    def _known(self, name: str, names: Mapping[str, Any]) -> Any:
        if name in names:
            return names[name]
        raise InputError([unknown_name("name", name, known=list(names), where=self._where)])
