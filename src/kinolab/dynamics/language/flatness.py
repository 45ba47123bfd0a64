"""Differential flatness: states and inputs as functions of flat outputs, without integration.

A planner chooses a curve, which determines the coordinates; rates and inputs follow from the
equations of motion.

Source: Fliess, Levine, Martin, Rouchon, Flatness and defect of non-linear systems, Int. J. Control
61(6), 1995.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.frames import Number
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.symbols import Coordinate, MachineSymbol


class OutputSymbol(MachineSymbol):
    """A flat output, or one of its derivatives."""

    def __new__(cls, name: str, order: int = 0) -> OutputSymbol:
        """Make a symbol; users call ``output``."""
        return cls._build(name + "'" * order, (name, order))


@checked
def output(name: str, order: int = 0) -> OutputSymbol:
    """Return the symbol of the flat output of a name, or of its derivative of order up to 2."""
    return OutputSymbol(name, order)


CURVATURE = output("curvature")  # of a plane curve, in [1/m], positive to the left


@checked
@dataclass(frozen=True)
class PlaneCurves:
    """A machine that rolls along plane curves; path and timing are independent.

    Attributes:
        x: Coordinate x of the point that follows the curve.
        y: Coordinate y of the same point.
        heading: Along the curve when driving forward, opposite when reversing.
        steered: Coordinates determined by the curvature, as expressions of
            ``CURVATURE`` and parameters.
    """

    x: Coordinate
    y: Coordinate
    heading: Coordinate
    steered: tuple[tuple[Coordinate, sympy.Expr], ...] = ()

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinates determined by the curve."""
        return (self.x, self.y, self.heading, *(coordinate for coordinate, _ in self.steered))


@checked
@dataclass(frozen=True)
class FlatOutputs:
    """A machine whose coordinates are functions of flat outputs and their time derivatives.

    Forces neglected here, such as small friction, are compensated by the steering method.

    Attributes:
        outputs: Names of the outputs, and their definitions in the coordinates.
        determined: Coordinates as expressions of ``output(name, order)``, of parameters, and
            of coordinates listed before.
    """

    outputs: tuple[tuple[str, Number], ...]
    determined: tuple[tuple[Coordinate, Number], ...]

    def __post_init__(self) -> None:
        """Convert numbers to expressions."""
        for name in ("outputs", "determined"):
            pairs = tuple((key, exact(value)) for key, value in getattr(self, name))
            object.__setattr__(self, name, pairs)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinates determined by the outputs."""
        return tuple(coordinate for coordinate, _ in self.determined)


Flat: TypeAlias = PlaneCurves | FlatOutputs


def output_symbols(outputs: Iterable[str]) -> Iterator[OutputSymbol]:
    """Yield the output symbols that expressions may use besides the machine's own."""
    yield CURVATURE
    for name in outputs:
        # 3 derivative orders of an output in a flat map: 0 to 2, as curves provide
        yield from (output(name, order) for order in range(3))
