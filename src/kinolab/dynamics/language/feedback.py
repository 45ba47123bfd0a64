"""Feedback laws as part of a machine: planners choose references, the law computes inputs.

Sampling torques hardly ever works for an unstable machine: nearly all of them make it fall. So its
controller is part of the propagated dynamics, as it is of the real machine. The law is evaluated at
the beginning of every propagation step; its output is saturated at the input limits and held until
the next step (zero-order hold), as by a digital controller.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, TypeAlias

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.frames import Number
from kinolab.dynamics.language.inputs import Limit
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.symbols import InputSymbol, ReferenceSymbol

Named: TypeAlias = str | InputSymbol | ReferenceSymbol  # an input or reference, by name or symbol
Law: TypeAlias = Mapping[Named, Number] | Sequence[tuple[Named, Number]]
Sizes: TypeAlias = Mapping[Named, float] | Sequence[tuple[Named, float]]
Degrees: TypeAlias = Mapping[Named, int] | Sequence[tuple[Named, int]]
Deviations: TypeAlias = Mapping[Number, float] | Sequence[tuple[Number, float]]
Values: TypeAlias = Mapping[Number, Number] | Sequence[tuple[Number, Number]]


@checked
@dataclass(frozen=True)
class Reference:
    """A set point of a feedback law, chosen by planners: a speed, a lean, an attitude.

    Attributes:
        name: Its name in scenarios and files.
        limit: Largest magnitude, or (lower, upper), in ``unit``.
        unit: SI unit as text, empty if dimensionless.
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
    """A feedback law: every input as an expression in the state and in references.

    Args:
        references: Planned instead of the inputs, in this order.
        law: An expression per input, by the input's name or its symbol. It may contain coordinates,
            independent rates, auxiliary states, parameters and references' symbols.
    """

    references: tuple[Reference, ...]
    law: tuple[tuple[str, sympy.Expr], ...]

    def __init__(
        self,
        references: Sequence[Reference],
        law: Law,
    ) -> None:
        named = tuple((str(name), exact(expression)) for name, expression in _pairs(law))
        vars(self).update(references=tuple(references), law=named)


@checked
@dataclass(frozen=True, init=False)
class Regulator:
    """An LQR that kinolab designs about the equilibrium of each reference value.

    For every value of the references there is an equilibrium, or a steady motion, with constant
    tracked expressions; about it the law is u = u0 + K (z0 - z). With ``schedule``, u0, z0 and K
    are polynomials in the references, interpolated at equilibria on Chebyshev points.

    Args:
        references: Planned instead of the inputs, in this order.
        tracked: The output z, as expressions in coordinates, independent rates, auxiliary states
            and parameters, each with its large deviation. It must determine its own rates of
            change; the machine's position in the plane does not.
        about: Equilibrium values, in references' symbols and parameters, of as many tracked
            expressions as determine the equilibrium.
        efforts: Large effort per input; the larger of its limits when left out.
        schedule: Polynomial degree in each reference on which gains and inputs depend. Other
            references enter only through ``about``.

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
        vars(self).update(
            references=tuple(references),
            tracked=tuple((exact(z), float(large)) for z, large in _pairs(tracked)),
            about=tuple((exact(z), exact(value)) for z, value in _pairs(about)),
            efforts=tuple((str(name), float(large)) for name, large in _pairs(efforts)),
            schedule=tuple((str(name), int(degree)) for name, degree in _pairs(schedule)),
        )


def _pairs(table: Mapping[Any, Any] | Sequence[tuple[Any, Any]]) -> Sequence[tuple[Any, Any]]:
    return list(table.items()) if isinstance(table, Mapping) else list(table)
