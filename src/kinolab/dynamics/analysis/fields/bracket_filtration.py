"""Filtration of Lie brackets at a point by jets, layer by layer, without symbolic expressions.

Layer k holds brackets [X_1, [X_2, … X_k]] of k fields, the innermost an input's: together with the
drift they span the Lie algebra (Dynkin). Components at rounding level count as 0, judged by the
bracket's magnitude without cancellation, which is computed along with it.

Source: Jean, Control of Nonholonomic Systems: from Sub-Riemannian Geometry to Motion Planning,
2014, section 1.3.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from kinolab.dynamics.analysis.fields.vector_fields import DRIFT, VectorFields
from kinolab.dynamics.analysis.jets.jet_evaluation import jets_of
from kinolab.dynamics.analysis.jets.jets import Jet, JetSpace, jet_space, work_of
from kinolab.dynamics.analysis.jets.scalars import AbstractNumbers, Floats, Rationals, rational

Word: TypeAlias = tuple[str, ...]  # (X_1, …, X_k) stands for [X_1, [X_2, … X_k]]


@dataclass(frozen=True, eq=False)
class Bracket:
    """A Lie bracket's jet about a point.

    Attributes:
        word: Names of its fields, outermost first.
        jet: Its components' jets, shape (n, size).
        spread: Their magnitudes without cancellation, same shape; None where exact.
    """

    word: Word
    jet: Jet
    spread: Jet | None

    @property
    def vector(self) -> Jet:
        """The bracket at the point itself, shape (n,)."""
        return self.jet[:, 0]

    @property
    def size(self) -> Jet:
        """Effective magnitude of its components, shape (n,): larger where they mostly cancelled."""
        own = np.abs(self.vector)
        # Smaller components have few digits, and are not scaled up in rank decisions.
        return own if self.spread is None else np.maximum(own, 1e-6 * self.spread[:, 0])


@dataclass(frozen=True, eq=False)
class BracketFiltration:
    """The brackets of some fields about one point.

    Attributes:
        drift: The drift, with constant inputs included; None if there is none.
        inputs: The input fields.
        degree: Largest number of fields in a bracket.
    """

    drift: Bracket | None
    inputs: tuple[Bracket, ...]
    degree: int

    @classmethod
    def at(
        cls,
        fields: VectorFields,
        point: Mapping[str, Any],
        degree: int,
        *,
        held: Mapping[str, float] | None = None,
        exact: bool = False,
    ) -> BracketFiltration:
        """Expand fields about a point, to the order that brackets of ``degree`` fields need.

        Args:
            point: Value of every state entry, by name.
            degree: Largest number of fields in a bracket.
            held: Constant inputs, by name, which become part of the drift.
            exact: Whether to use rational arithmetic.
        """
        values = dict(fields.values) | dict(point)
        values = {n: rational(n, value) if exact else float(value) for n, value in values.items()}
        return cls.of(fields, values, degree, Rationals() if exact else Floats(), held=held)

    @classmethod
    def of(
        cls,
        fields: VectorFields,
        values: Mapping[str, Any],
        degree: int,
        numbers: AbstractNumbers,
        *,
        held: Mapping[str, float] | None = None,
    ) -> BracketFiltration:
        """Expand fields in any number type; ``values`` are of all variables, by name."""
        outputs = [node for parts in fields.components.values() for node in parts]
        jets = jets_of(fields.tape, outputs, fields.state, values, degree - 1, numbers)
        blocks = jets.reshape(len(fields.components), len(fields.state), -1)
        found = dict(zip(fields.components, blocks, strict=True))
        for name, value in (held or {}).items():
            if value:
                found[DRIFT] = found.get(DRIFT, 0) + numbers.constant(value) * found[name]
        drift = _base(DRIFT, found[DRIFT]) if DRIFT in found else None
        return cls(drift, tuple(_base(n, j) for n, j in found.items() if n != DRIFT), degree)

    @property
    def generators(self) -> tuple[Bracket, ...]:
        """The generating fields, the drift first."""
        return (*([self.drift] if self.drift else []), *self.inputs)

    def __iter__(self) -> Iterator[tuple[Bracket, ...]]:
        """Yield the layers, without brackets that vanish about the point."""
        layer = self.inputs
        yield layer
        for k in range(2, self.degree + 1):
            space = jet_space(len(self.inputs[0].jet), self.degree - k) if self.inputs else None
            layer = tuple(self._next(layer, space, first=k == 2)) if space else ()
            yield layer

    def _next(
        self, layer: tuple[Bracket, ...], space: JetSpace, *, first: bool
    ) -> Iterator[Bracket]:
        skipped = 1 if self.drift else 0
        for i, outer in enumerate(self.generators):
            for j, inner in enumerate(layer):
                if first and i - skipped >= j:
                    continue  # [g, g] = 0 and [g_j, g_i] = -[g_i, g_j] add nothing
                made = bracket(space, outer, inner)
                if made.jet.any():
                    yield made


def work_for(fields: VectorFields, degree: int) -> int:
    """Estimate the multiplications for all brackets of up to ``degree`` fields at a point."""
    n, generators = len(fields.state), len(fields.components)
    outputs = [node for parts in fields.components.values() for node in parts]
    total = 2 * len(fields.tape.needed(outputs)) * work_of(n, degree - 1)
    count = len(fields.inputs)
    for k in range(2, degree + 1):
        count *= generators
        total += 4 * count * n * n * work_of(n, degree - k)
    return total


def _base(name: str, jet: Jet) -> Bracket:
    if jet.dtype == object:
        return Bracket((name,), jet, None)
    size = np.abs(jet)
    # 1e-2 of a field's largest coefficient; lower bound on every coefficient's spread
    return Bracket((name,), jet, np.maximum(size, 1e-2 * size.max(initial=0.0)))


def bracket(space: JetSpace, f: Bracket, g: Bracket) -> Bracket:
    """Return [f, g] = Dg f - Df g, one order lower than g."""
    higher = jet_space(space.variables, space.order + 1)
    fj, gj = (higher.lower(part.jet, space.order + 1) for part in (f, g))
    made = _along(space, higher, gj, fj) - _along(space, higher, fj, gj)
    word = (*f.word, *g.word)
    if f.spread is None or g.spread is None:
        return Bracket(word, made, None)
    fs, gs = (higher.lower(spread, space.order + 1) for spread in (f.spread, g.spread))
    spread = _along(space, higher, gs, fs) + _along(space, higher, fs, gs)
    # 1e-14 of a component before cancellation; smaller ones count as 0
    return Bracket(word, np.where(np.abs(made) > 1e-14 * spread, made, 0.0), spread)


def _along(space: JetSpace, higher: JetSpace, function: Jet, direction: Jet) -> Jet:
    """Differentiate functions, shape (n, size), along a field of the same shape."""
    slopes = higher.gradient(function)
    terms = space.product(slopes, space.lower(direction, space.order)[None])
    return np.asarray(terms.sum(axis=1))
