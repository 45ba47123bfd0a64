"""Lie brackets of vector fields as SymPy expressions."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.lagrange.printing import one_line, written_length
from kinolab.dynamics.language.frames import Number
from kinolab.dynamics.symbols.expressions import exact
from kinolab.errors import InputError, Mistake


@checked
@final
@dataclass(frozen=True, init=False)
class VectorField:
    """A vector field in coordinates.

    Attributes:
        variables: The coordinates x, shape (n,).
        components: Components of the field, shape (n,).
    """

    variables: tuple[sympy.Symbol, ...]
    components: tuple[sympy.Expr, ...]

    def __init__(self, variables: Sequence[sympy.Symbol], components: Sequence[Number]) -> None:
        object.__setattr__(self, "variables", tuple(variables))
        object.__setattr__(self, "components", tuple(map(exact, components)))
        if len(self.variables) != len(self.components):
            what = f"it has {len(self.components)} components for {len(self.variables)} variables."
            raise InputError([Mistake("vector field", what)])

    def along(self, function: sympy.Expr) -> sympy.Expr:
        """Return the Lie derivative of a function along the field."""
        slopes = (sympy.diff(function, x) for x in self.variables)
        return sympy.Add(*(f * slope for f, slope in zip(self.components, slopes, strict=True)))

    def at(self, values: Mapping[sympy.Symbol, object]) -> sympy.Matrix:
        """Evaluate the field at a point, shape (n, 1)."""
        return sympy.Matrix(self.components).subs(values)

    # 2.0 [s] after which no further component is simplified
    def tidy(self, budget: float = 2.0) -> VectorField:
        """Simplify for reading; the budget in [s] is checked between components."""
        deadline = time.monotonic() + budget
        return VectorField(self.variables, [_tidied(c, deadline) for c in self.components])

    def __str__(self) -> str:
        lengths = map(written_length, self.components)
        written = (
            one_line(component)
            if length <= 20_000  # symbols and operations of a component that is printed
            else f"an expression of length {length:.0e}"
            for component, length in zip(self.components, lengths, strict=True)
        )
        pairs = zip(self.variables, written, strict=True)
        return "\n".join(f"{one_line(x)}: {text}" for x, text in pairs)


@checked
def lie_bracket(f: VectorField, g: VectorField) -> VectorField:
    """Return [f, g] = Dg f - Df g: the net motion of f, g, -f, -g to second order.

    Nothing is simplified; ``.tidy()`` does, for reading.

    Raises:
        InputError: If the fields have different variables.

    Source: Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, 7.2.
    """
    if f.variables != g.variables:
        remedy = "Write both in the same variables, in the same order."
        raise InputError([Mistake("Lie bracket", "the fields have different variables.", remedy)])
    pairs = zip(f.components, g.components, strict=True)
    return VectorField(f.variables, [f.along(b) - g.along(a) for a, b in pairs])


def _tidied(component: sympy.Expr, deadline: float) -> sympy.Expr:
    # 400 symbols and operations of a component that SymPy simplifies quickly
    if written_length(component) > 400 or time.monotonic() > deadline:
        return component
    tried = sympy.trigsimp(sympy.cancel(sympy.expand(component)))
    return min(component, sympy.factor_terms(tried), key=lambda entry: entry.count_ops())
