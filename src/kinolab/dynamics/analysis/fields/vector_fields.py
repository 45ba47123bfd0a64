"""Control-affine systems as vector fields: x_dot = drift(x) + sum of u_i g_i(x)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice

import numpy as np
import sympy

from kinolab.arguments import checked
from kinolab.dynamics.analysis.fields.brackets import VectorField
from kinolab.dynamics.analysis.fields.to_sympy import to_sympy
from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node
from kinolab.dynamics.derivation.lowering import Lowering
from kinolab.dynamics.symbols.expressions import exact
from kinolab.errors import InputError, Mistake

REGULAR_SAMPLES = 3  # sampled states; a single one may be degenerate
DRIFT = "drift"  # name of the drift field


@checked
@dataclass(frozen=True, eq=False)
class VectorFields:
    """A drift and input fields on one state space.

    Stored in an expression graph, which is compact for any machine; ``field`` returns SymPy
    expressions, which become unreadable for large machines.

    Attributes:
        symbols: The state entries, in the author's symbols, shape (n,).
        tape: The expression graph of the components.
        state: Nodes of the state's variables.
        drift: Components of the drift field; all zero for a driftless system.
        inputs: Components of each input's field, by name.
        values: Values of all other symbols, by name.
        dimension: Of the state manifold: n minus one per unit quaternion and per constraint on the
            state.
        constants: The symbols that ``values`` names.
        points: Regular, consistent states, by name.
        held: Whether states must satisfy equations besides unit quaternions.
        prolonged: Whether inputs became states, with their rates as inputs (prolongation).
    """

    symbols: tuple[sympy.Symbol, ...]
    tape: ExpressionGraph
    state: tuple[Node, ...]
    drift: tuple[Node, ...]
    inputs: Mapping[str, tuple[Node, ...]]
    values: Mapping[str, float]
    dimension: int
    constants: tuple[sympy.Symbol, ...]
    points: tuple[Mapping[str, float], ...]
    held: bool = False
    prolonged: bool = False

    @classmethod
    def of(
        cls,
        symbols: Sequence[sympy.Symbol],
        inputs: Mapping[str, Sequence[sympy.Expr]],
        *,
        drift: Sequence[sympy.Expr] | None = None,
        values: Mapping[sympy.Symbol, float] | None = None,
    ) -> VectorFields:
        """Make vector fields from expressions.

        Args:
            inputs: Components of each input's field, by a name.
            drift: Components of the drift field; nothing when left out.

        Raises:
            InputError: If a field lacks a component per symbol, or has an unknown symbol.
        """
        tape, values = ExpressionGraph(), values or {}
        bound = {symbol: tape.variable(symbol.name) for symbol in (*symbols, *values)}
        lower = Lowering(tape, bound)
        given = {DRIFT: drift if drift is not None else [0] * len(symbols), **inputs}
        lowered = {}
        for name, components in given.items():
            if len(components) != len(symbols):
                what = f"it has {len(components)} components; the state has {len(symbols)}."
                raise InputError([Mistake(f"vector field {name!r}", what)])
            lowered[name] = tuple(lower(exact(component)) for component in components)
        return cls(
            symbols=tuple(symbols),
            tape=tape,
            state=tuple(bound[symbol] for symbol in symbols),
            drift=lowered.pop(DRIFT),
            inputs=lowered,
            values={symbol.name: float(value) for symbol, value in values.items()},
            dimension=len(symbols),
            constants=tuple(values),
            points=random_points(tuple(symbol.name for symbol in symbols)),
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the state entries, shape (n,)."""
        return tuple(symbol.name for symbol in self.symbols)

    @property
    def driftless(self) -> bool:
        """Whether the drift vanishes everywhere."""
        return all(node == self.tape.zero for node in self.drift)

    @cached_property
    def components(self) -> Mapping[str, tuple[Node, ...]]:
        """All fields by name, the drift first if there is one."""
        return ({} if self.driftless else {DRIFT: self.drift}) | dict(self.inputs)

    def field(self, name: str) -> VectorField:
        """Return one field as expressions; ``drift`` names the drift.

        Raises:
            InputError: If there is no such field.
        """
        known = {DRIFT: self.drift, **self.inputs}
        if name not in known:
            remedy = f"Known: {', '.join(known)}."
            raise InputError([Mistake("", f"no vector field is called {name!r}.", remedy)])
        named = {symbol.name: symbol for symbol in (*self.symbols, *self.constants)}
        return VectorField(self.symbols, to_sympy(self.tape, known[name], named))

    def __iter__(self) -> Iterator[VectorField]:
        """Yield all fields as expressions, the drift first if there is one."""
        return (self.field(name) for name in self.components)


def random_points(names: tuple[str, ...]) -> tuple[dict[str, float], ...]:
    """Return random points for variables of unknown range; deterministic."""
    generator = np.random.default_rng(0)
    return tuple(
        {name: float(generator.uniform(-1, 1)) for name in names} for _ in range(REGULAR_SAMPLES)
    )


def first(samples: Iterator[dict[str, float]]) -> tuple[dict[str, float], ...]:
    """Return the first sampled states of a machine, the rest state skipped."""
    return tuple(islice(samples, 1, 1 + REGULAR_SAMPLES))


def combination_text(coefficients: Iterable[float], names: Iterable[str]) -> str:
    """Print a linear combination: ``theta_1 - 0.5 theta_2``."""
    terms = [(float(c), name) for c, name in zip(coefficients, names, strict=True)]
    largest = max((abs(c) for c, _ in terms), default=0.0)
    text = ""
    for c, name in terms:
        if abs(c) > 1e-6 * largest:  # of the largest coefficient; smaller ones are not printed
            size = f"{abs(c):.4g}"  # printed of a coefficient
            sign = ("-" if c < 0 else "") if not text else (" - " if c < 0 else " + ")
            text += sign + (name if size == "1" else f"{size} {name}")
    return text or "0"
