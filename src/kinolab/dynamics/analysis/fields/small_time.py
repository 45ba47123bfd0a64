"""Small-time local controllability by Sussmann's sufficient condition.

A bracket is bad if it has an odd number of drifts and an even number of each input: no choice of
inputs changes its sign. At the state, every bad bracket, summed over all permutations of inputs,
must be a combination of brackets of fewer fields. The condition is sufficient, not necessary.

For a single bounded input, the bad bracket [g, [f, g]] also settles the question: if at an
equilibrium it is no combination of g, [f, g], [f, [f, g]], ..., then the system is not small-time
locally controllable.

Source: Sussmann, A general theorem on local controllability, SIAM J. Control and Optimization
25(1), 1987, with theta = 1; Chow, Math. Ann. 117, 1939, without drift; Sussmann, Lie brackets and
local controllability: a sufficient condition for scalar-input systems, SIAM J. Control and
Optimization 21(5), 1983, proposition 6.3, for a single input.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any, NoReturn

import numpy as np

from kinolab.arguments import checked
from kinolab.dynamics.analysis.fields.bad_brackets import symmetrised
from kinolab.dynamics.analysis.fields.bracket_filtration import (
    Bracket,
    BracketFiltration,
    Word,
    work_for,
)
from kinolab.dynamics.analysis.fields.growth_vectors import (
    MAX_DEGREE,
    MAX_WORK,
    filtration,
    has_kink,
    rank_of_brackets,
    stacked,
)
from kinolab.dynamics.analysis.fields.linear_controllability import reachable_subspace
from kinolab.dynamics.analysis.fields.points import complete_point
from kinolab.dynamics.analysis.fields.vector_fields import VectorFields
from kinolab.dynamics.analysis.jets.ranks import RANK_TOLERANCE
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array

SQUARE = 3  # fields in [g, [f, g]]


class SmallTime(Enum):
    """Outcome of the test; the value is the sentence the user reads."""

    DRIFTLESS = "It can reach every nearby state in a short time: its brackets span all directions."
    LINEAR = "It can reach every nearby state in a short time: even its linearisation can."
    BRACKETS = "It can reach every nearby state in a short time: Sussmann's condition holds."
    UNDECIDED = "Sussmann's condition is not met, which settles nothing."
    UNFINISHED = "Sussmann's condition needs longer brackets than there is time to compute."
    KINKED = "The equations of motion have a kink at this state, so their brackets settle nothing."
    MOVING = "It does not stay at this state, so Sussmann's condition does not apply."
    ONE_SIDED = "An input cannot be both increased and decreased, so no condition applies."
    ONE_WAY = "Some nearby states are out of reach in a short time: a bracket acts one way only."
    UNREACHABLE = "Some nearby states are out of its reach: brackets do not span all directions."

    @classmethod
    def _missing_(cls, value: object) -> NoReturn:
        known = ", ".join(f"SmallTime.{outcome.name}" for outcome in cls)
        raise InputError([Mistake("SmallTime value", f"it is {value!r}.", f"Give one of {known}.")])


@checked
@dataclass(frozen=True)
class SmallTimeVerdict:
    """The verdict on small-time local controllability at a state.

    Attributes:
        outcome: Outcome of the test.
        degree: Largest number of fields in the deciding brackets.
        obstacle: A bad bracket that brackets of fewer fields do not neutralise, if any.
    """

    outcome: SmallTime
    degree: int = 0
    obstacle: Word | None = None

    @property
    def controllable(self) -> bool | None:
        """Whether the system is small-time locally controllable; None if unknown."""
        if self.outcome in (SmallTime.DRIFTLESS, SmallTime.LINEAR, SmallTime.BRACKETS):
            return True
        return False if self.outcome in (SmallTime.UNREACHABLE, SmallTime.ONE_WAY) else None


@checked
def small_time_controllability(
    fields: VectorFields,
    at: Mapping[Any, Any],
    held: Mapping[str, float] | None = None,
    *,
    limits: Mapping[str, tuple[float, float]] | None = None,
    exact: bool = False,
    tolerance: float = RANK_TOLERANCE,
    work: int = MAX_WORK,
) -> SmallTimeVerdict:
    """Decide, if possible, small-time local controllability at a state.

    Args:
        fields: Of the machine.
        at: The state, by name; missing entries are 0.
        held: Inputs that hold the system at this state, by name.
        limits: Of the inputs, by name; symmetric when left out.
        exact: Use rational arithmetic at a rational state.
        tolerance: Relative tolerance of ranks.
        work: Limit of multiplications.
    """
    point = complete_point(fields, at)
    held = held or {}
    spans = (limits or {}).items()
    if not all(lower < held.get(name, 0.0) < upper for name, (lower, upper) in spans):
        return SmallTimeVerdict(SmallTime.ONE_SIDED)
    if not filtration(fields, tolerance=tolerance, work=work).full_or_unknown:
        return SmallTimeVerdict(SmallTime.UNREACHABLE)
    local = BracketFiltration.at(fields, point, 2, held=held, exact=exact)
    if local.drift is not None and not _rests(local.drift):
        return SmallTimeVerdict(SmallTime.MOVING, 1)
    linearised = local.drift is not None and not exact
    if linearised and _reached(fields, local).shape[1] == fields.dimension:
        return SmallTimeVerdict(SmallTime.LINEAR, 2)
    if has_kink(fields, point):
        return SmallTimeVerdict(SmallTime.KINKED)
    for degree in range(1, MAX_DEGREE + 1):
        layers = BracketFiltration.at(fields, point, degree, held=held, exact=exact)
        verdict = _sussmann(layers, fields.dimension, tolerance)
        if verdict is not None:
            one_way = not exact and verdict.obstacle and _one_way(fields, local, layers, verdict)
            return replace(verdict, outcome=SmallTime.ONE_WAY) if one_way else verdict
        if work_for(fields, degree + 1) > work:
            break
    return SmallTimeVerdict(SmallTime.UNFINISHED, degree)


def _sussmann(
    layers: BracketFiltration, dimension: int, tolerance: float
) -> SmallTimeVerdict | None:
    """Apply the test to the given brackets; None where longer ones must decide."""
    shorter: list[Bracket] = []
    outcome = SmallTime.DRIFTLESS if layers.drift is None else SmallTime.BRACKETS
    inputs = tuple(bracket.word[0] for bracket in layers.inputs)
    for degree, layer in enumerate(layers, 1):
        bad = symmetrised(layer, inputs)
        obstacle = next(_not_made_up(bad, shorter, tolerance), None)
        if obstacle is not None:
            return SmallTimeVerdict(SmallTime.UNDECIDED, degree, obstacle.word)
        shorter += layer
        if rank_of_brackets(shorter, tolerance).value == dimension:
            return SmallTimeVerdict(outcome, degree)
    return None


def _not_made_up(
    bad: Sequence[Bracket], shorter: Sequence[Bracket], tolerance: float
) -> Iterator[Bracket]:
    """Yield the bad brackets that shorter ones do not neutralise."""
    before = rank_of_brackets(shorter, tolerance).value
    if bad and rank_of_brackets([*shorter, *bad], tolerance).value > before:
        for one in bad:
            if rank_of_brackets([*shorter, one], tolerance).value > before:
                yield one


def _rests(drift: Bracket) -> bool:
    if drift.spread is None:
        return not drift.vector.any()
    # 1e-7 of the drift's components, relative to their terms
    return bool((np.abs(drift.vector) <= 1e-7 * drift.spread[:, 0].max()).all())


def _reached(fields: VectorFields, layers: BracketFiltration) -> Array:
    """Return an orthonormal basis of what the linearisation reaches, shape (states, rank)."""
    assert layers.drift is not None
    A = layers.drift.jet[:, 1 : 1 + len(fields.state)]
    found: Array = reachable_subspace(A, stacked(layers.inputs).T)
    return found


def _one_way(
    fields: VectorFields,
    local: BracketFiltration,
    layers: BracketFiltration,
    found: SmallTimeVerdict,
) -> bool:
    """Whether a single input's bracket [g, [f, g]] leaves the span of all brackets with one g.

    At an equilibrium that span is the reachable subspace of the linearisation.
    """
    if local.drift is None or len(local.inputs) != 1 or found.degree != SQUARE:
        return False
    (bad,) = (bracket for bracket in list(layers)[SQUARE - 1] if bracket.word == found.obstacle)
    reached = _reached(fields, local)
    missed = bad.vector - reached @ (reached.T @ bad.vector)
    # 1e-6, relative: what rounding may leave of a bracket that is in the span
    return bool(np.linalg.norm(missed) > 1e-6 * np.linalg.norm(bad.vector))
