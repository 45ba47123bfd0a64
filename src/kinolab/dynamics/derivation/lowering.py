"""Lowering of SymPy expressions, which users write, to nodes of an expression graph."""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce

import sympy

from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node
from kinolab.dynamics.language.quantities import FrameQuantity
from kinolab.errors import InputError, Mistake

FUNCTIONS: dict[type, str] = {
    sympy.sin: "sin",
    sympy.cos: "cos",
    sympy.tan: "tan",
    sympy.exp: "exp",
    sympy.log: "log",
    sympy.tanh: "tanh",
    sympy.atan: "atan",
    sympy.Abs: "fabs",
    sympy.sign: "sign",
}


class Lowering:
    """Lowers expressions to one graph; symbols become the nodes they are bound to."""

    def __init__(self, tape: ExpressionGraph, symbols: Mapping[sympy.Symbol, Node]) -> None:
        self.tape = tape
        self.symbols = dict(symbols)
        self._memo: dict[sympy.Expr, Node] = dict(symbols)

    def __call__(self, expression: sympy.Expr) -> Node:
        """Return the node of an expression.

        Raises:
            InputError: If it has a symbol that is no coordinate, rate, parameter or input, or a
                function that kinolab does not compile.
        """
        known = self._memo.get(expression)
        if known is None:
            known = self._memo[expression] = self._translate(expression)
        return known

    def _translate(self, expression: sympy.Expr) -> Node:
        tape = self.tape
        if isinstance(expression, FrameQuantity):  # its value depends on the motion
            return tape.variable(expression.name)
        if expression.is_Symbol:
            remedy = "Make it with length, angle, parameter or rate, and use it in the machine."
            raise InputError([Mistake("", f"the symbol {expression} is not declared.", remedy)])
        if expression.is_number:
            try:
                return tape.constant(float(expression))
            except (TypeError, OverflowError) as error:
                what = f"{expression} is not a real number."
                raise InputError([Mistake("", what)]) from error
        if isinstance(expression, sympy.Add):
            return tape.sum(self(term) for term in expression.args)
        if isinstance(expression, sympy.Mul):
            return self._product(expression)
        if isinstance(expression, sympy.Pow):
            return self._power(expression)
        if isinstance(expression, sympy.Max):
            return reduce(tape.maximum, map(self, expression.args))
        name = FUNCTIONS.get(expression.func)
        if name is None:
            known = ", ".join(sorted(function.__name__ for function in (*FUNCTIONS, sympy.Max)))
            what = f"{expression.func.__name__} cannot be compiled."
            raise InputError([Mistake("", what, f"Known functions: {known}, sqrt and powers.")])
        return tape.unary(name, self(expression.args[0]))

    def _product(self, expression: sympy.Mul) -> Node:
        numerator, denominator = self.tape.one, self.tape.one
        for factor in expression.args:
            base, exponent = factor.as_base_exp()
            if exponent.is_number and exponent.is_negative:
                power = self(sympy.Pow(base, -exponent))
                denominator = self.tape.mul(denominator, power)
            else:
                numerator = self.tape.mul(numerator, self(factor))
        return self.tape.div(numerator, denominator)

    def _power(self, expression: sympy.Pow) -> Node:
        base, exponent = expression.args
        if exponent.is_number:
            return self.tape.power(self(base), float(exponent))
        if base == sympy.E:
            return self.tape.unary("exp", self(exponent))
        if base.is_number and not base.is_positive:
            what = f"{expression} is not a real number for every {exponent}."
            raise InputError([Mistake("", what)])
        logarithm = self.tape.unary("log", self(base))
        return self.tape.unary("exp", self.tape.mul(self(exponent), logarithm))
