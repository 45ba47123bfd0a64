"""Feedback as part of a machine: a planner chooses references, and the inputs follow from them.

A machine that falls over cannot be planned for by sampling its torques: nearly all of them make it
fall. Its controller is part of what is propagated instead, as it is part of the machine that is
built. The law is evaluated at the beginning of every propagation step; what it gives is cut at the
inputs' limits and held until the next one, as a digital controller does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, TypeAlias

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.expressions import exact
from kinolab.dynamics.language.frames import Number
from kinolab.dynamics.language.inputs import Limit
from kinolab.dynamics.language.symbols import InputSymbol, ReferenceSymbol

Named: TypeAlias = str | InputSymbol | ReferenceSymbol  # an input or reference, by name or symbol
Law: TypeAlias = Mapping[Named, Number] | Sequence[tuple[Named, Number]]
Sizes: TypeAlias = Mapping[Named, float] | Sequence[tuple[Named, float]]
Degrees: TypeAlias = Mapping[Named, int] | Sequence[tuple[Named, int]]
Deviations: TypeAlias = Mapping[Number, float] | Sequence[tuple[Number, float]]
Values: TypeAlias = Mapping[Number, Number] | Sequence[tuple[Number, Number]]


@checked
@dataclass(frozen=True)
class Reference:
    """A set point of a feedback law, which a planner chooses: a speed, a lean, an attitude.

    Attributes:
        name: What scenarios and files call it.
        limit: Largest magnitude, or (lower, upper), in ``unit``.
        unit: SI unit as text, empty for a pure number.
    """

    name: str
    _: KW_ONLY
    limit: Limit
    unit: str = ""

    @property
    def symbol(self) -> ReferenceSymbol:
        """The symbol of the reference's value."""
        return ReferenceSymbol(self.name)


@checked
@dataclass(frozen=True, init=False)
class Feedback:
    """A law that gives every input of a machine, as an expression in its state and in references.

    Args:
        references: What is chosen instead of the inputs, in this order.
        law: An expression per input, by the input's name or its symbol. It may contain coordinates,
            independent rates, further states, parameters and references' symbols.
    """

    references: tuple[Reference, ...]
    law: tuple[tuple[str, sympy.Expr], ...]

    def __init__(
        self,
        references: Sequence[Reference],
        law: Law,
    ) -> None:
        object.__setattr__(self, "references", tuple(references))
        named = tuple((str(name), exact(expression)) for name, expression in _pairs(law))
        object.__setattr__(self, "law", named)


@checked
@dataclass(frozen=True, init=False)
class Regulator:
    """A law that kinolab designs: linear-quadratic regulation about equilibria, one per reference.

    For every value of the references there is an equilibrium, or a steady motion, in which what is
    tracked stays as it is; about it the law is u = u0 + K (z0 - z). Where ``schedule`` says so, u0,
    z0 and K follow the references as polynomials through the equilibria at Chebyshev's points.

    Args:
        references: What is chosen instead of the inputs, in this order.
        tracked: What the law looks at, z, as expressions in coordinates, independent rates, further
            states and parameters, each with the deviation that counts as large. It must decide its
            own rates of change: where the machine stands on the plane does not.
        about: The value in an equilibrium, in references' symbols and parameters, of as many
            tracked expressions as decide it.
        efforts: The effort that counts as large, per input; the larger of its limits if left out.
        schedule: The degree of the polynomials in each reference that the equilibria differ with.
            The others change only what ``about`` says.

    Source: Bryson, Ho, Applied Optimal Control, 1975, section 5.2 (the weights, one over the square
    of a large deviation); Rugh, Shamma, Research on gain scheduling, Automatica 36, 2000.
    """

    references: tuple[Reference, ...]
    tracked: tuple[tuple[sympy.Expr, float], ...]
    about: tuple[tuple[sympy.Expr, sympy.Expr], ...]
    efforts: tuple[tuple[str, float], ...]
    schedule: tuple[tuple[str, int], ...]

    def __init__(
        self,
        references: Sequence[Reference],
        *,
        tracked: Deviations,
        about: Values,
        efforts: Sizes = (),
        schedule: Degrees = (),
    ) -> None:
        values = {
            "references": tuple(references),
            "tracked": tuple((exact(z), float(large)) for z, large in _pairs(tracked)),
            "about": tuple((exact(z), exact(value)) for z, value in _pairs(about)),
            "efforts": tuple((str(name), float(large)) for name, large in _pairs(efforts)),
            "schedule": tuple((str(name), int(degree)) for name, degree in _pairs(schedule)),
        }
        for field, value in values.items():
            object.__setattr__(self, field, value)


def _pairs(table: Mapping[Any, Any] | Sequence[tuple[Any, Any]]) -> Sequence[tuple[Any, Any]]:
    return list(table.items()) if isinstance(table, Mapping) else list(table)
