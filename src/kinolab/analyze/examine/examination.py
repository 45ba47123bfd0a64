"""``plan examine``: what a machine does, what looks wrong about it, and whether its laws hold."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from textwrap import wrap

import numpy as np

from kinolab.analyze.describe.each_mode import in_each_mode
from kinolab.analyze.examine.behaviour import behaviour
from kinolab.analyze.examine.dampers import dampers, fixed_drags
from kinolab.analyze.examine.drums import drums, wound
from kinolab.analyze.examine.energy_sources import energy_sources
from kinolab.analyze.examine.flat_map import flat_map
from kinolab.analyze.examine.forces_twice import forces_twice, held_twice, turned_twice
from kinolab.analyze.examine.law_check import LawCheck
from kinolab.analyze.examine.laws import laws, modes_alone
from kinolab.analyze.examine.left_out import left_out, unheeded
from kinolab.analyze.examine.odd_numbers import odd_numbers
from kinolab.analyze.examine.reactions import (
    others_axes,
    parted_axles,
    passed_joints,
    reactions,
    same_effects,
    turned_away,
    turning_axes,
    without_effect,
)
from kinolab.analyze.examine.remarks.place_in_file import place_in
from kinolab.analyze.examine.remarks.remark import Remark, sorted_out
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.analyze.examine.resting import overturned, pushed_down, without_rest
from kinolab.analyze.examine.ropes import pushing_ropes, ropes
from kinolab.analyze.examine.shapes.carried import left_behind, on_their_own_axis, swung_off
from kinolab.analyze.examine.shapes.joints import parted, sized_otherwise
from kinolab.analyze.examine.shapes.landings import landings
from kinolab.analyze.examine.shapes.passing_bodies import passing_bodies
from kinolab.analyze.examine.shapes.rolling import slips
from kinolab.analyze.examine.shapes.steered_wheels import steering
from kinolab.analyze.examine.shapes.touching_bodies import contacts, standing
from kinolab.analyze.examine.shapes.twins import required, twins
from kinolab.analyze.examine.units_agree import units_agree
from kinolab.dynamics import System
from kinolab.errors import LINE_WIDTH, counted
from kinolab.loading.well_posed import unlimited_sentences
from kinolab.numerics.arrays import Array
from kinolab.scenario.schema import IntegrationSection
from kinolab.simulation.held_law import stiff_law, wrong_law
from kinolab.simulation.stability import fastest_rate, step_too_long


@dataclass(frozen=True)
class Examination:
    """What an examination of a machine has found.

    Attributes:
        name: Of the machine.
        sentences: What it does, with titles where it has modes.
        remarks: What is hardly ever meant, but for what the machine expects.
        laws: The laws of mechanics that were checked.
        unused: Entries of ``expected`` that no remark answers to.
    """

    name: str
    sentences: tuple[str, ...]
    remarks: tuple[Remark, ...]
    laws: tuple[LawCheck, ...]
    unused: tuple[str, ...] = ()

    @property
    def broken(self) -> tuple[LawCheck, ...]:
        """The laws that do not hold."""
        return tuple(law for law in self.laws if not law.holds)

    @property
    def faults(self) -> tuple[str, ...]:
        """What speaks against the machine: remarks, broken laws, and what is expected in vain."""
        vain = (f"expected={entry!r} answers to no remark" for entry in self.unused)
        return (*map(str, self.remarks), *map(str, self.broken), *vain)

    @property
    def verdict(self) -> str:
        """All of it in one line."""
        if not self.faults:
            return f"{self.name}: nothing to remark, and the laws of mechanics hold."
        counts = {"remark": len(self.remarks), "broken law": len(self.broken)}
        counts["expectation in vain"] = len(self.unused)
        told = [counted(n, what) for what, n in counts.items() if n]
        titles = "; ".join((*(r.title for r in self.remarks), *(law.law for law in self.broken)))
        return f"{self.name}: {', '.join(told)}{': ' * bool(titles)}{titles}."

    def __str__(self) -> str:
        """What ``plan examine`` prints."""
        return "\n".join(_lines(self))

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Show it in a notebook."""
        remarks = "".join(f"<li>{escape(str(remark))}</li>" for remark in self.remarks)
        told = "".join(f"<li>{escape(sentence)}</li>" for sentence in self.sentences)
        broken = "".join(f"<li>{escape(str(law))}</li>" for law in self.broken)
        parts = [f"<b>{escape(self.verdict)}</b>", f"<ul>{told}</ul>"]
        parts += [f"Remarks:<ul>{remarks}</ul>"] if remarks else []
        parts += [f"Broken laws:<ul>{broken}</ul>"] if broken else []
        return "".join(parts)


def examine(
    system: System,
    integration: IntegrationSection | None = None,
    *,
    file: Path | None = None,
    start: Array | None = None,
) -> Examination:
    """Examine a machine.

    Args:
        integration: How planning integrates it; not checked if left out.
        file: The file that describes it, in which the lines of remarks are looked up.
        start: The state (nx,) at which a scenario begins; left out where it says nothing of it.

    Raises:
        InputError: If the machine cannot be derived.
    """
    sentences: list[str] = []
    found: list[Remark] = []
    checked = list(modes_alone(system.model())) if system.modes else []
    law, advice = _law_of(system, integration)
    chosen = None if (step := _advice(system, integration)) else integration
    for title, machine in in_each_mode(system):
        subject = Subject(machine.with_feedback(None))
        passing, left_out = passing_bodies(subject)
        begun = None if system.modes else start
        told = (*behaviour(subject, begun), passing, *_limits(machine), step, advice)
        sentences += [title] * bool(title)
        sentences += [one for one in told if one and one not in sentences]
        found += (*remarks_on(subject), *left_out)
        mode = title.partition("\n")[0].removeprefix(system.name)
        checked += [replace(law, law=law.law + mode) for law in laws(machine, chosen)]
    found += (*law, *unheeded(system, file), *landings(system))
    if not system.modes:  # in one of which a rope may be slack
        found += ropes(Subject(system.with_feedback(None)))
        found += without_effect(Subject(system.with_feedback(None)))
    remarks, unused = sorted_out(found, system.expected)
    placed = tuple(replace(one, place=place_in(file, one.part)) for one in remarks)
    return Examination(system.name, tuple(sentences), placed, tuple(checked), unused)


def _advice(system: System, integration: IntegrationSection | None) -> str:
    """Return what a step must be that nobody has chosen; empty if the usual one is stable."""
    if integration is None or integration.model_fields_set & {"method", "step", "substeps"}:
        return ""
    wrong = step_too_long(integration, fastest_rate(system.model()))
    return "" if wrong is None else f"Before planning, choose a step. {wrong.sentence}"


def remarks_on(subject: Subject) -> Iterator[Remark]:
    """Yield what is hardly ever meant about a machine, without its controller."""
    touching = list(contacts(subject))
    for contact in touching:
        yield from slips(contact)
        yield from parted(contact)
        yield from sized_otherwise(contact)
    yield from swung_off(subject, touching)
    yield from left_behind(subject)
    yield from on_their_own_axis(subject)
    yield from standing(subject)
    yield from reactions(subject)
    yield from turned_away(subject)
    yield from others_axes(subject)
    yield from parted_axles(subject)
    yield from passed_joints(subject)
    yield from turning_axes(subject)
    yield from same_effects(subject)
    yield from steering(subject)
    yield from twins(subject)
    yield from required(subject)
    yield from left_out(subject)
    yield from odd_numbers(subject)
    yield from units_agree(subject)
    yield from energy_sources(subject)
    yield from without_rest(subject)
    yield from pushed_down(subject)
    yield from overturned(subject)
    yield from drums(subject)
    yield from wound(subject)
    yield from pushing_ropes(subject)
    yield from dampers(subject)
    yield from fixed_drags(subject)
    yield from forces_twice(subject)
    yield from turned_twice(subject)
    yield from held_twice(subject)
    yield from flat_map(subject)


def _law_of(
    system: System, integration: IntegrationSection | None
) -> tuple[tuple[Remark, ...], str]:
    """Return what is wrong about a machine's law, and advice on a step that nobody has chosen."""
    if system.feedback is None or integration is None:
        return (), ""
    word = type(system.feedback).__name__
    if wrong := wrong_law(system.model(), integration):
        inputs = ", ".join(entry.name for entry in system.inputs)
        return (Remark("law that pushes the wrong way", inputs, wrong, (word, "")),), ""
    found = stiff_law(system.model(), integration, lambda: system)
    if found is None:
        return (), ""
    if integration == IntegrationSection() and found.holds >= found.step / 2:
        return (), f"Before planning, choose a step. {found.sentence}"
    return (Remark("law too stiff for its step", "", found.sentence, (word, "")),), ""


def _limits(system: System) -> Iterator[str]:
    """Yield the limits and inputs that a planner will miss, in the words in which it asks."""
    model = system.model()
    names = [
        model.state_names[i] for i in model.speeds if not np.isfinite(model.state_bounds[i]).all()
    ]
    if names:
        yield f"Before planning, {' '.join(unlimited_sentences(model, names))}"
    if not model.nu:
        yield "It has no inputs: there is nothing to plan; plan simulate shows how it moves."


def _lines(found: Examination) -> Iterator[str]:
    yield found.name
    for sentence in found.sentences:
        yield from _wrapped(sentence, "  ", "    ")
    for remark in found.remarks:
        yield from _wrapped(str(remark), "  remark  ", "          ")
    for entry in found.unused:
        yield f"  remark  expected={entry!r} answers to no remark: take it out."
    own = [law for law in found.laws if law.own and law.holds]
    for law in found.laws:
        if law not in own:
            yield from _wrapped(str(law), "  ", "          ")
    if own:
        yield f"  holds   {len(own)} checks of kinolab's own derivation"
    yield found.verdict


def _wrapped(text: str, first: str, others: str) -> list[str]:
    lines = text.splitlines()
    wrapped = wrap(lines[0], LINE_WIDTH, initial_indent=first, subsequent_indent=others)
    return [*wrapped, *(f"{others}{line.strip()}" for line in lines[1:])]
