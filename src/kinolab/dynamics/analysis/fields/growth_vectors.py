"""Growth vectors and ranks of vector fields and Lie brackets, and kinks, where none exist."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from kinolab.arguments import checked
from kinolab.dynamics.analysis.fields.bracket_filtration import (
    Bracket,
    BracketFiltration,
    Word,
    work_for,
)
from kinolab.dynamics.analysis.fields.brackets import VectorField
from kinolab.dynamics.analysis.fields.points import complete_point, rational_point
from kinolab.dynamics.analysis.fields.vector_fields import VectorFields
from kinolab.dynamics.analysis.jets.ranks import RANK_TOLERANCE, Rank, Vectors, rank_of
from kinolab.dynamics.symbols.symbols import Parameter
from kinolab.errors import InputError, Mistake

MAX_DEGREE = 12  # of a bracket; growth vectors of the course's machines end much earlier
MAX_WORK = 400_000_000  # multiplications per point, a few seconds
KINKED = ("fabs", "sign", "fmax")


@checked
@dataclass(frozen=True)
class Filtration:
    """The spans of brackets of up to 1, 2, … fields at a point.

    Attributes:
        growth: Dimensions of the spans, by the number of fields, up to the last increase.
        dimension: Of the state space.
        complete: Whether longer brackets provably add nothing; else the work limit was reached.
        margins: By the number of fields, the rank with its singular values.
    """

    growth: tuple[int, ...]
    dimension: int
    complete: bool
    margins: tuple[Rank, ...]

    @property
    def rank(self) -> int:
        """Dimension of the span of all brackets."""
        return self.growth[-1] if self.growth else 0

    @property
    def full(self) -> bool:
        """Whether they span the tangent space."""
        return self.rank == self.dimension

    @property
    def full_or_unknown(self) -> bool:
        """Whether they span the tangent space, or might with longer brackets."""
        return self.full or not self.complete


@checked
def growth_vector(
    fields: VectorFields | Sequence[VectorField],
    at: Mapping[Any, Any] | None = None,
    *,
    exact: bool = False,
    tolerance: float = RANK_TOLERANCE,
) -> tuple[int, ...]:
    """Return the growth vector: dimensions spanned by brackets of up to 1, 2, … fields.

    The drift counts as a field. Empty without inputs.

    Args:
        fields: Of a machine, by ``vector_fields`` or ``allowed_motions``, or as expressions.
        at: The point, by name; missing entries are 0. Random regular points when left out.
        exact: Use rational arithmetic at a rational point: numbers are read as exact decimals,
            angles as ``pi / 2`` or ``atan(Rational(3, 4))``.
        tolerance: Fraction of the largest singular value below which one counts as 0.

    Raises:
        InputError: If the state has no such variable, is at a kink of the fields, or is not
            rational where it must be.

    Source: Murray, Sastry, Nonholonomic motion planning: steering using sinusoids, IEEE Trans.
    Automatic Control 38(5), 1993.
    """
    return filtration(_as_fields(fields), at, exact=exact, tolerance=tolerance).growth


@checked
def filtration(
    fields: VectorFields,
    at: Mapping[Any, Any] | None = None,
    *,
    strong: bool = False,
    exact: bool = False,
    tolerance: float = RANK_TOLERANCE,
    work: int = MAX_WORK,
) -> Filtration:
    """Return the filtration by brackets of vector fields; see ``growth_vector``.

    Args:
        at: The point, by name; random regular points when left out.
        strong: Leave out the drift itself, but not its brackets (strong accessibility: states
            reached at one and the same time).
        exact: Use rational arithmetic.
        tolerance: Relative tolerance of ranks.
        work: Limit of multiplications per point.
    """

    def spans(point: Mapping[str, Any], degree: int, *, exact: bool) -> list[Rank]:
        layers = BracketFiltration.at(fields, point, degree, exact=exact)
        found = [] if strong or layers.drift is None else [layers.drift]
        ranks = []
        for layer in layers:
            found += layer
            ranks.append(rank_of_brackets(found, tolerance))
        return ranks

    if at is None and exact:
        points = [rational_point(fields, point) for point in fields.points]
        return _regular(fields, points, partial(spans, exact=True), work)
    regular = _regular(fields, fields.points, partial(spans, exact=False), work)
    if at is None:
        return regular
    point = complete_point(fields, at)
    if has_kink(fields, point):
        what = "the vector fields have a kink at this state, and no brackets."
        raise InputError([Mistake("growth vector", what, "Choose a state beside it, or none.")])
    degree = max(len(regular.growth), 1)
    while True:
        ranks = spans(point, degree, exact=exact)
        enough = ranks[-1].value >= regular.rank
        if enough or degree == MAX_DEGREE or work_for(fields, degree + 1) > work:
            return _made(fields, ranks, regular.complete and enough)
        degree += 1


def _regular(
    fields: VectorFields,
    points: Sequence[Mapping[str, Any]],
    spans: Callable[[Mapping[str, Any], int], list[Rank]],
    work: int,
) -> Filtration:
    """Return the filtration at regular points, where it ends with a layer that adds nothing."""
    for degree in range(1, MAX_DEGREE + 1):
        ranks = spans(points[0], degree)
        full = ranks[-1].value == fields.dimension
        closed = degree > 1 and ranks[-1].value == ranks[-2].value
        short = degree == MAX_DEGREE or work_for(fields, degree + 1) > work
        if full or closed or short:
            others = [spans(point, degree) for point in points[1:]]
            best = max([ranks, *others], key=lambda each: [rank.value for rank in each])
            return _made(fields, best, full or closed)
    raise AssertionError("the highest degree ends the search")


def _made(fields: VectorFields, ranks: Sequence[Rank], complete: bool) -> Filtration:
    values = [rank.value for rank in ranks]
    length = values.index(values[-1]) + 1
    return Filtration(tuple(values[:length]), fields.dimension, complete, tuple(ranks[:length]))


def rank_of_brackets(brackets: Sequence[Bracket], tolerance: float = RANK_TOLERANCE) -> Rank:
    """Return the rank of brackets at their point."""
    if not brackets:
        return Rank(0)
    sizes = np.array([bracket.size for bracket in brackets])
    return rank_of(stacked(brackets), tolerance, sizes)


def stacked(brackets: Sequence[Bracket]) -> Vectors:
    """Return the vectors of brackets at their point, one per row."""
    return np.array([bracket.vector for bracket in brackets])


def word_text(word: Word) -> str:
    """Print a nested bracket: ``[drive, [drift, steer]]``."""
    return word[0] if len(word) == 1 else f"[{word[0]}, {word_text(word[1:])}]"


def _as_fields(fields: VectorFields | Sequence[VectorField]) -> VectorFields:
    if isinstance(fields, VectorFields):
        return fields
    named = {f"g{k}": field.components for k, field in enumerate(fields, 1)}
    symbols = {
        symbol for field in fields for part in field.components for symbol in part.free_symbols
    }
    values = {symbol: symbol.default for symbol in symbols if isinstance(symbol, Parameter)}
    return VectorFields.of(fields[0].variables, named, values=values)


def has_kink(fields: VectorFields, point: Mapping[str, Any]) -> bool:
    """Return whether an absolute value, or similar, has its kink at a state.

    Args:
        point: Value of every state entry, by name.
    """
    tape, moving = fields.tape, frozenset(fields.state)
    outputs = [node for parts in fields.components.values() for node in parts]
    kinks = [
        operation.operands
        for operation in map(tape.operations.__getitem__, tape.needed(outputs))
        if operation.name in KINKED and any(tape.depends_on(o) & moving for o in operation.operands)
    ]
    if not kinks:
        return False
    values = {name: float(value) for name, value in (dict(fields.values) | dict(point)).items()}
    gaps = [tape.sub(pair[0], pair[1]) if len(pair) > 1 else pair[0] for pair in kinks]
    # 1e-9 of an argument's distance to its kink
    return min(map(abs, tape.evaluate(gaps, values))) < 1e-9
