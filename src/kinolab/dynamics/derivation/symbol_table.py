"""The symbol table: a machine's symbols as graph variables, and what is imposed on them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import sympy

from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node
from kinolab.dynamics.derivation.lowering import Lowering
from kinolab.dynamics.language.frames import motion_of
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import (
    ImposedVelocity,
    configuration_symbols,
    imposed_accelerations,
    imposed_velocities,
    quasi_velocities,
    state_parts,
    tangent_symbols,
)
from kinolab.dynamics.language.quasi_velocities import QuasiVelocity
from kinolab.dynamics.symbols.expressions import exact
from kinolab.errors import InputError, Mistake
from kinolab.numerics.manifolds.state_parts import Part

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
        parts: Of the configuration, as ``state_parts``.
        quasi: The quasi-velocities that the author chose as independent velocities.
        imposed: Velocities that inputs, auxiliary states and time impose.
        driven: Indices of the velocities whose acceleration is an input, with its node.
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
    parts: tuple[Part, ...]
    quasi: tuple[QuasiVelocity, ...]
    imposed: tuple[ImposedVelocity, ...]
    driven: dict[int, Node]

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
        quasi, rates = quasi_velocities(system), [symbol.name for symbol in v]
        lower = Lowering(tape, bound | {each.symbol: lower(each.velocity) for each in quasi})
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
            parts=state_parts(system),
            quasi=quasi,
            imposed=tuple(imposed_velocities(system)),
            driven={
                rates.index(f"{coordinate}_dot"): bound[symbol]
                for coordinate, symbol in imposed_accelerations(system).items()
            },
        )

    @property
    def by_multipliers(self) -> bool:
        """Whether all velocities are states, and accelerations follow from multipliers."""
        return self.system.velocities == "all" and bool(self.system.constraints)

    def names(self, nodes: Iterable[Node]) -> list[str]:
        """Return the names of variables."""
        return [self.tape.operations[node].label for node in nodes]

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
