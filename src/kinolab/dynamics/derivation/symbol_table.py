"""The symbol table: a machine's symbols as graph variables, and random values of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import sympy

from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node
from kinolab.dynamics.derivation.lowering import Lowering
from kinolab.dynamics.language.frames import motion_of
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import (
    configuration_symbols,
    quasi_velocities,
    state_parts,
    tangent_symbols,
)
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.symbols import Coordinate
from kinolab.errors import InputError, Mistake
from kinolab.numerics.manifolds.state_parts import spheres_of

SOME_VELOCITY = "State a velocity, such as V.y or rate(x)."


@dataclass(frozen=True)
class SymbolTable:
    """Graph variables for every symbol of a machine.

    Attributes:
        system: The machine.
        tape: The expression graph of the variables.
        lower: Lowers the machine's expressions to the graph.
        configuration: Entries of the configuration q; four for an attitude.
        tangent: The velocities, one per degree of freedom of q; three for an attitude.
        flow_rows: q_dot, as nodes in ``tangent`` and ``configuration``.
        states: The auxiliary states.
        inputs: The inputs.
        parameters: The parameters.
    """

    system: Mechanism
    tape: ExpressionGraph
    lower: Lowering
    configuration: tuple[Node, ...]
    tangent: tuple[Node, ...]
    flow_rows: tuple[Node, ...]
    states: tuple[Node, ...]
    inputs: tuple[Node, ...]
    parameters: tuple[Node, ...]

    @classmethod
    def of(cls, system: Mechanism) -> SymbolTable:
        """Build a graph with a variable per symbol."""
        tape = ExpressionGraph()
        q, v = configuration_symbols(system), tangent_symbols(system)
        further = [entry.symbol for entry in system.states]
        controls = [entry.symbol for entry in system.inputs]
        bound: dict[sympy.Symbol, Node] = {
            symbol: tape.variable(symbol.name)
            for symbol in (*q, *v, *further, *controls, *system.parameters)
        }
        lower = Lowering(tape, bound)
        quasi = {v.symbol: lower(v.velocity) for v in quasi_velocities(system)}
        lower = Lowering(tape, bound | quasi)
        return cls(
            system=system,
            tape=tape,
            lower=lower,
            configuration=tuple(bound[symbol] for symbol in q),
            tangent=tuple(bound[symbol] for symbol in v),
            flow_rows=tuple(lower(motion_of(symbol)) for symbol in q),
            states=tuple(bound[symbol] for symbol in further),
            inputs=tuple(bound[symbol] for symbol in controls),
            parameters=tuple(bound[symbol] for symbol in system.parameters),
        )

    def flow(self, velocities: Sequence[Node] | None = None) -> dict[Node, Node]:
        """Return q_dot at given velocities, by the nodes of q."""
        rows = list(self.flow_rows)
        if velocities is not None:
            rows = self.tape.substitute(rows, self.at(velocities))
        return dict(zip(self.configuration, rows, strict=True))

    def slopes(self, velocity: sympy.Expr) -> tuple[Node, tuple[Node, ...]]:
        """Return a velocity's node, and its derivative by each velocity of the machine."""
        tape, node = self.tape, self.lower(exact(velocity))
        return node, tuple(tape.derivative([node], {v: tape.one})[0] for v in self.tangent)

    def linear_slopes(
        self, velocity: sympy.Expr, where: Callable[[], str]
    ) -> tuple[Node, tuple[Node, ...]]:
        """Return what ``slopes`` does, for a velocity that must be linear in those of the machine.

        Raises:
            InputError: If it is not; ``where`` returns what it is the velocity of.
        """
        node, covector = self.slopes(velocity)
        if self._moves(covector):
            node, covector = self.slopes(sympy.expand(velocity))
        if self._moves(covector):
            raise InputError([Mistake(where(), "it is not linear in the rates.", SOME_VELOCITY)])
        return node, covector

    def _moves(self, nodes: Sequence[Node]) -> bool:
        moving = frozenset(self.tangent)
        return any(self.tape.depends_on(node) & moving for node in nodes)

    def at(self, velocities: Sequence[Node]) -> Mapping[Node, Node]:
        """Return the substitution of the velocity variables by given nodes."""
        return dict(zip(self.tangent, velocities, strict=True))


# More than 12 never changed a choice.
def sampled_values(system: Mechanism, count: int = 12) -> Iterator[dict[str, float]]:
    """Yield values of all symbols by name: the rest position first, then random ones in limits.

    For decisions made once, which must be reproducible: the same machine always gives the same
    values.
    """
    generator = np.random.default_rng(0)
    names = [symbol.name for symbol in configuration_symbols(system)]
    for k in range(count):
        values = dict(system.parameter_values)
        for coordinate in system.coordinates:
            if isinstance(coordinate, Coordinate):
                value = random_value(coordinate, generator)
                values[coordinate.name] = value if k else rest_value(coordinate)
                values[f"{coordinate.name}_dot"] = float(generator.normal())
            else:
                values |= {s.name: float(generator.normal()) for s in coordinate.entries}
                values |= {s.name: float(generator.normal()) for s in coordinate.rates}
        for part in spheres_of(state_parts(system)):
            own = names[part.own]
            length = float(np.linalg.norm([values[name] for name in own]))
            values |= {name: values[name] / length if length else 0.0 for name in own}
            values[own[-1]] += 0.0 if length else 1.0
        values |= {entry.name: float(generator.normal()) for entry in system.states}
        values |= {entry.name: float(generator.normal()) for entry in system.inputs}
        yield values


def rest_value(coordinate: Coordinate) -> float:
    """Return a coordinate's default start: 0, or the limit nearest to it."""
    return min(max(0.0, coordinate.lower), coordinate.upper)


def random_value(coordinate: Coordinate, generator: np.random.Generator) -> float:
    """Sample a coordinate: anywhere on a circle, within its limits on a line."""
    if coordinate.topology == "circle":
        return float(generator.uniform(-np.pi, np.pi))
    lower, upper = coordinate.lower, coordinate.upper
    if not np.isfinite(lower):
        lower = (upper if np.isfinite(upper) else coordinate.scale) - 2 * coordinate.scale
    if not np.isfinite(upper):
        upper = lower + 2 * coordinate.scale
    return float(generator.uniform(lower, upper))
