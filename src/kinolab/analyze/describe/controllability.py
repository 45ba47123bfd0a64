"""Sentences about a machine's controllability."""

from __future__ import annotations

from collections.abc import Iterator

from kinolab.analyze.describe.at_rest import AtRest
from kinolab.analyze.describe.description import Description
from kinolab.dynamics.analysis.fields.growth_vectors import word_text
from kinolab.dynamics.analysis.fields.linear_controllability import LinearControllability
from kinolab.dynamics.analysis.fields.small_time import SmallTime, SmallTimeVerdict
from kinolab.dynamics.lagrange.printing import one_line
from kinolab.dynamics.language.inputs import bounds_of
from kinolab.errors import a_few, counted, row_of


def sentences(found: Description) -> Iterator[str]:
    """Yield sentences about configurations, then states, then equilibria."""
    yield from _configurations(found)
    if found.decoupling is not None:
        yield from found.decoupling.sentences()
    yield _states(found)
    for rest in found.rests:
        yield f"Near {_place(rest)}: {_linear(rest.linear)}"
        if rest.small_time is not None:
            yield f"{rest.small_time.outcome.value}{_decided_by(rest.small_time)}"


def _configurations(found: Description) -> Iterator[str]:
    closure = found.closure
    if closure is None or not found.constraints:
        return
    growth = ", ".join(map(str, closure.growth))
    yield (
        f"The motions that the constraints allow have the growth vector ({growth}): their brackets "
        f"of up to {counted(len(closure.growth), 'field')} span {closure.leaf} of the "
        f"{closure.dimension} dimensions of the configuration space."
    )
    if found.pushes == found.freedom:
        one, each = "the only motion", f"each of the {found.freedom} independent motions"
        along = one if found.freedom == 1 else each
        yield f"The inputs act along {along} that the constraints allow{_followed(found)}."
    for combination in closure.combinations:
        yield f"Together, {combination} can be integrated: holonomic in disguise."
    for integral in closure.integrals:
        yield f"{one_line(integral)} never changes."


def _followed(found: Description) -> str:
    """Say which paths can be followed if every admissible motion is actuated."""
    limits = [(entry, *bounds_of(entry)) for entry in found.inputs]
    one_way = [
        f"{entry.name} one way only ({lower:g} to {upper:g} {entry.unit})"
        for entry, lower, upper in limits
        if not lower < 0 < upper
    ]
    if one_way:
        return f", {', '.join(one_way)}"
    if found.potential:
        return ", so it can follow any path made of such motions along which they are strong enough"
    return ", so it can follow any path made of such motions if it moves slowly enough"


def _states(found: Description) -> str:
    spanned, whole = found.accessible, found.accessible.dimension
    growth = ", ".join(map(str, spanned.growth)) or "0"
    states = "states that the constraints allow" if found.constraints else "state space"
    if found.prolonged:
        states += " and the inputs, which count as states here because one does not enter linearly"
    begin = f"Brackets of the equations of motion span ({growth}) of the {whole} dimensions of the "
    begin += f"{states}: "
    if spanned.full:
        return begin + "from every regular state it can reach an open set (it is accessible)."
    if spanned.complete:
        lost = f"{whole - spanned.rank} are out of reach (it is not accessible)"
        return begin + f"{lost}; something never changes, whatever the inputs do."
    return begin + "more may be spanned by longer brackets."


def _place(rest: AtRest) -> str:
    """Name an equilibrium by the values that differ from the default."""
    values = rest.state | rest.held
    usual = {name: 1.0 if name in rest.upright else 0.0 for name in values}
    # 1e-9 of a state or input: smaller deviations are not reported
    named = [
        f"{name} = {value:.4g}" for name, value in values.items() if abs(value - usual[name]) > 1e-9
    ]
    if not named:
        return "rest, all states and inputs 0"
    return f"rest at {a_few(named)}"


def _linear(linear: LinearControllability) -> str:
    if linear.controllable:
        return (
            f"the linearisation is controllable ({linear.rank} of {linear.dimension} dimensions)."
        )
    lost, more = list(linear.directions[:4]), len(linear.directions) - 4
    if more > 0:
        lost.append(f"{more} more")
    decays = "the rest decays by itself" if linear.stabilisable else "not all of that decays"
    return (
        f"the linearisation reaches {linear.rank} of {linear.dimension} dimensions. No input "
        f"affects {row_of(lost, 'or')}, and {decays}."
    )


def _decided_by(verdict: SmallTimeVerdict) -> str:
    if verdict.outcome in (SmallTime.DRIFTLESS, SmallTime.BRACKETS):
        return f" Brackets of up to {counted(verdict.degree, 'field')} settle it."
    if verdict.outcome is SmallTime.UNFINISHED:
        return f" Those of up to {counted(verdict.degree, 'field')} do not settle it."
    if verdict.obstacle is not None:
        return f" The bad bracket {word_text(verdict.obstacle)} is not compensated."
    return ""
