"""Flat machines: all of a motion follows from a curve, without integrating anything.

A planner draws the curve and reads off the coordinates; their rates and the inputs follow from the
machine's own equations.

Source: Fliess, Levine, Martin, Rouchon, Flatness and defect of non-linear systems, Int. J. Control
61(6), 1995.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.expressions import exact
from kinolab.dynamics.language.frames import Number
from kinolab.dynamics.language.symbols import Coordinate, MachineSymbol

MAX_ORDERS = 3  # of an output that a flat map may use: 0 to 2, which is what curves are drawn with


class OutputSymbol(MachineSymbol):
    """A flat output, or one of its derivatives."""

    __slots__ = ()

    def __new__(cls, name: str, order: int = 0) -> OutputSymbol:
        """Make a symbol; users call ``output``."""
        made: OutputSymbol = cls._build(name + "'" * order, (name, order))
        return made


@checked
def output(name: str, order: int = 0) -> OutputSymbol:
    """Return the symbol of a flat output, or of its derivative by time of an order up to 2."""
    return OutputSymbol(name, order)


CURVATURE = output("curvature")  # of a plane curve, in [1/m], positive to the left


@checked
@dataclass(frozen=True)
class PlaneCurves:
    """A machine that rolls along plane curves; how fast is decided apart from where.

    Attributes:
        x: Of the point that follows the curve.
        y: Of the same point.
        heading: Along the curve where the machine goes forward, against it where it goes back.
        steered: Coordinates that the curve's curvature determines, as expressions of
            ``CURVATURE`` and parameters.
    """

    x: Coordinate
    y: Coordinate
    heading: Coordinate
    steered: tuple[tuple[Coordinate, sympy.Expr], ...] = ()

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """What the curve determines."""
        return (self.x, self.y, self.heading, *(coordinate for coordinate, _ in self.steered))


@checked
@dataclass(frozen=True)
class FlatOutputs:
    """A machine whose coordinates follow from some outputs and their derivatives by time.

    Forces that are left out here, such as a little friction, are made up for by whoever steers.

    Attributes:
        outputs: Names of the outputs, and the expressions of the coordinates that they are.
        determined: The coordinates as expressions of ``output(name, order)``, of parameters, and
            of coordinates listed before.
    """

    outputs: tuple[tuple[str, Number], ...]
    determined: tuple[tuple[Coordinate, Number], ...]

    def __post_init__(self) -> None:
        """Let numbers stand for expressions."""
        for name in ("outputs", "determined"):
            pairs = tuple((key, exact(value)) for key, value in getattr(self, name))
            object.__setattr__(self, name, pairs)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """What the outputs determine."""
        return tuple(coordinate for coordinate, _ in self.determined)


Flat: TypeAlias = PlaneCurves | FlatOutputs


def output_symbols(outputs: Iterable[str]) -> Iterator[OutputSymbol]:
    """Yield every symbol that expressions may use beyond the machine's own."""
    yield CURVATURE
    for name in outputs:
        yield from (output(name, order) for order in range(MAX_ORDERS))


def symbols_used(flat: Flat) -> set[sympy.Symbol]:
    """Return the symbols of all expressions of a flat map."""
    pairs = flat.steered if isinstance(flat, PlaneCurves) else (*flat.outputs, *flat.determined)
    return {symbol for _, expression in pairs for symbol in exact(expression).free_symbols}
