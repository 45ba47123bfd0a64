"""The vector fields of a machine: x_dot = drift(x) + sum of u_i g_i(x)."""

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
from kinolab.dynamics.language.expressions import exact
from kinolab.errors import InputError, Mistake

REGULAR_SAMPLES = 3  # sampled states; one alone may lie badly
DRIFT = "drift"  # what the field is called that acts without inputs


@checked
@dataclass(frozen=True, eq=False)
class VectorFields:
    """A drift and input fields on one state space.

    They live on a tape, where any machine is small; ``field`` gives one as SymPy expressions, which
    grow beyond reading for large machines.

    Attributes:
        symbols: The entries of the state, in the author's symbols, shape (n,).
        tape: Where the components are.
        state: The variables of the state.
        drift: Components of the field that acts without inputs; all zero for a driftless system.
        inputs: Components of each input's field, by name.
        values: Of all other symbols, by name.
        dimension: Of the manifold on which the state lives: n less one per unit quaternion and per
            constraint on the state.
        constants: The symbols that ``values`` names.
        points: Regular states, by name, that satisfy what states must.
        held: Whether states must satisfy equations other than unit quaternions.
        prolonged: Whether inputs are states here, and their rates the inputs.
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
            symbols: The state.
            inputs: Components of each input's field, by a name.
            drift: Components of the field that acts without inputs; nothing when left out.
            values: Of further symbols.

        Raises:
            InputError: If a field has not one component per symbol, or an unknown symbol.
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
        """Names of the entries of the state, shape (n,)."""
        return tuple(symbol.name for symbol in self.symbols)

    @property
    def driftless(self) -> bool:
        """Whether nothing moves without inputs, wherever the system is."""
        return all(node == self.tape.zero for node in self.drift)

    @cached_property
    def components(self) -> Mapping[str, tuple[Node, ...]]:
        """All fields by name, the drift first where there is one."""
        return ({} if self.driftless else {DRIFT: self.drift}) | dict(self.inputs)

    def field(self, name: str) -> VectorField:
        """Return one field as expressions; ``drift`` names the one without inputs.

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
        """Yield all fields as expressions, the drift first where there is one."""
        return (self.field(name) for name in self.components)


def random_points(names: tuple[str, ...]) -> tuple[dict[str, float], ...]:
    """Return values of variables about which nothing is known; the same ones every time."""
    generator = np.random.default_rng(0)
    return tuple(
        {name: float(generator.uniform(-1, 1)) for name in names} for _ in range(REGULAR_SAMPLES)
    )


def first(samples: Iterator[dict[str, float]]) -> tuple[dict[str, float], ...]:
    """Return sampled states of a machine; the very first, at rest, is none of them."""
    return tuple(islice(samples, 1, 1 + REGULAR_SAMPLES))


DIGITS = 4  # of a coefficient that is told
MIN_COEFFICIENT = 1e-6  # of the largest coefficient: one below is not told


def combination_text(coefficients: Iterable[float], names: Iterable[str]) -> str:
    """Write a linear combination: ``theta_1 - 0.5 theta_2``."""
    terms = [(float(c), name) for c, name in zip(coefficients, names, strict=True)]
    largest = max((abs(c) for c, _ in terms), default=0.0)
    text = ""
    for c, name in terms:
        if abs(c) > MIN_COEFFICIENT * largest:
            size = f"{abs(c):.{DIGITS}g}"
            sign = ("-" if c < 0 else "") if not text else (" - " if c < 0 else " + ")
            text += sign + (name if size == "1" else f"{size} {name}")
    return text or "0"
