"""A machine's description as text for a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf
from textwrap import wrap

from kinolab.analyze.describe.controllability import sentences
from kinolab.analyze.describe.description import Description
from kinolab.analyze.describe.sizes import BodySize
from kinolab.dynamics.facts.machine_facts import CoordinateFacts
from kinolab.dynamics.language.inputs import Input, bounds_of
from kinolab.dynamics.model.units import in_digits
from kinolab.errors import LINE_WIDTH
from kinolab.problem.warnings import machine_warnings

SHOWN = {True: "yes", False: "no"}


def described_as_text(found: Description) -> str:
    """Return what ``plan describe`` prints."""
    return "\n".join(_lines(found))


def _lines(found: Description) -> Iterator[str]:
    yield found.name
    left, space = found.states.positions, f"{found.space}, dimension {found.dimension}"
    space += f" ({left} under its holonomic constraints)" if left < found.dimension else ""
    yield f"  configuration space: {space}"
    yield f"  degrees of freedom: {found.freedom}, states: {found.states.dimension}"
    yield f"    {found.states.parts()}"
    if found.states.storage():
        yield f"    {found.states.storage()}"
    if any(what != "rate of a coordinate" for _, what in found.velocities):
        yield from _group("velocities", found.velocities)
    if found.singular:
        yield from _wrapped(found.singular)
    yield from _group("bodies", [_body_row(body) for body in found.bodies])
    yield from _group("coordinates", [_coordinate_row(one) for one in found.machine.coordinates])
    yield from _group("constraints", [(c.name, c.kind) for c in found.constraints])
    yield from _group("inputs", [_input_row(entry) for entry in found.inputs])
    yield from _parameters(found)
    if required := [(one.name,) for one in found.machine.requirements]:
        yield from _group("requirements", required)
    yield from _watched(found)
    if said := [*machine_warnings(found.machine)]:
        yield "  warnings"
        for sentence in said:
            yield from _wrapped(sentence)
    yield from _known(found)
    yield "  controllability"
    for sentence in sentences(found):
        yield from _wrapped(sentence)
    yield "  generalisations of the upright rolling disk"
    for k, mode in enumerate(found.generalisations, 1):
        begin = f"    {k} {SHOWN[mode.shown]:3}  "
        yield from _wrapped(f"{mode.name}: {mode.why}", begin, " " * 11)
    if found.left_out:
        yield "  left out"
        for sentence in found.left_out:
            yield from _wrapped(sentence)


def _parameters(found: Description) -> Iterator[str]:
    """Yield the parameters of the machine, and the numbers that become such."""
    machine = found.machine
    what = {one.name: one.what for one in machine.offered}
    units = dict(found.units) | {one.name: one.unit for one in machine.offered}
    values = {one.name: one.value for one in machine.offered} | dict(machine.parameters)
    if rows := [
        (name, f"{in_digits(value, 6)} {units.get(name, '')}".rstrip(), what.get(name, ""))
        for name, value in values.items()
    ]:
        yield from _group("parameters", rows)


def _known(found: Description) -> Iterator[str]:
    """Yield the symmetries, what no input changes, and what is known of flatness."""
    symmetries = f"L does not depend on {', '.join(found.cyclic)}" if found.cyclic else ""
    if found.conserved:
        symmetries += f"; no input changes the momentum of {', '.join(found.conserved)}"
    for title, told in (
        ("symmetries", symmetries),
        ("no input changes", "; ".join(found.momenta)),
    ):
        if told:
            yield from _wrapped(f"{title}: {told}", "  ")
    if found.flat is not None:
        yield from _wrapped(str(found.flat), "  ")


def _watched(found: Description) -> Iterator[str]:
    """Yield the pairs that may not touch; other bodies may pass through each other."""
    if sum(body.extent is not None for body in found.bodies) < 2:
        return
    pairs = "; ".join(f"{a} and {b}" for a, b in found.watched)
    text = f"pairs that must not touch: {pairs or 'none; bodies may pass through each other'}"
    yield from _wrapped(text, "  ")


def _wrapped(text: str, first: str = "    ", others: str = "") -> list[str]:
    """Break a text into lines; all but the first are indented further."""
    others = others or f"{first}  "
    return wrap(text, LINE_WIDTH, initial_indent=first, subsequent_indent=others)


def _group(title: str, rows: Sequence[Sequence[str]]) -> Iterator[str]:
    yield f"  {title}: {len(rows) or 'none'}"
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        yield f"    {'  '.join(cells)}".rstrip()


def _body_row(body: BodySize) -> tuple[str, str, str]:
    extent = "no shape"
    if body.extent is not None:
        extent = f"{' x '.join(map(in_digits, body.extent))} m"
    weight = f"{in_digits(body.mass, 4)} kg"
    if not body.mass and body.inertia:  # such as a rotor, which only turns
        weight = f"{in_digits(body.inertia, 4)} kg m^2"
    return body.name, weight, extent


def _coordinate_row(coordinate: CoordinateFacts) -> tuple[str, str, str]:
    (lower, upper), unit, speed = coordinate.limits, coordinate.unit, coordinate.speed
    limits = f"{lower:g} to {upper:g} {unit}".rstrip()
    return coordinate.name, limits, f"at most {speed:g} {unit}/s" if speed < inf else ""


def _input_row(entry: Input) -> tuple[str, str, str]:
    lower, upper = bounds_of(entry)
    kind = type(entry).__name__.lower()
    return entry.name, kind, f"{lower:g} to {upper:g} {entry.unit}".rstrip()
