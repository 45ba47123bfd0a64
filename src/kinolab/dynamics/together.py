"""Several machines as one: their states side by side, and no two of them may touch."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from itertools import combinations
from typing import Any

import sympy

from kinolab.dynamics.derivation.derivation import derive
from kinolab.dynamics.facts.machine_facts import JOINT, member_of, members
from kinolab.dynamics.language.feedback import Feedback, Reference
from kinolab.dynamics.language.forces import Gravity
from kinolab.dynamics.language.frames import Axis, pose
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import atoms_of, coordinate_of
from kinolab.dynamics.language.quantities import UP
from kinolab.dynamics.language.shapes import DrawnMesh, Shape
from kinolab.dynamics.symbols.expressions import exact, parts_of
from kinolab.dynamics.symbols.symbols import MachineSymbol
from kinolab.errors import InputError, Mistake

WORDS = (  # of a machine, each of which belongs to one of several
    *("bodies", "constraints", "inputs", "efforts", "states", "requirements"),
    *("cables", "coordinates", "keep"),
)
NAMELESS = (Axis, Shape, DrawnMesh)  # whose ``name`` says of which kind they are


def together(machines: Mapping[str, Mechanism]) -> Mechanism:
    """Return one machine of several; all names have that of their machine before them.

    Args:
        machines: By name, two or more: ``x`` of the machine ``left`` becomes ``left_x``.

    Raises:
        InputError: If one has modes, or they differ in gravity.
    """
    mistakes = [*_misfits(machines)]
    if mistakes:
        raise InputError(mistakes)
    made = {name: _Renamed(f"{name}_")(system) for name, system in machines.items()}
    parts = [*made.values()]
    lawful = any(part.feedback is not None for part in parts)
    laws = [_law(part) for part in parts] if lawful else []
    chosen = any(part.velocities is not None for part in parts)
    words: dict[str, Any] = {
        key: [word for part in parts for word in getattr(part, key)]
        for key in (*WORDS, "unwatched", "notes")
    }
    return Mechanism(
        JOINT.join(made),
        **words,
        gravity=next((part.gravity for part in parts if part.gravity is not None), None),
        collisions=[*(pair for part in parts for pair in part.collisions), *_between(parts)],
        velocities=_velocities(parts) if chosen else None,
        values={name: value for part in parts for name, value in part.values},
        feedback=Feedback(
            [reference for law in laws for reference in law.references],
            [entry for law in laws for entry in law.law],
        )
        if laws
        else None,
    )


def part_of(system: Mechanism, name: str) -> Mechanism:
    """Return one machine of those that ``together`` has joined, under the names it has there."""
    machines = members(system.name)

    def own(words: Any) -> list[Any]:
        return [word for word in words if member_of(_name_in(word), machines) == name]

    def within(pairs: Any) -> list[Any]:
        return [pair for pair in pairs if len(own(pair)) == len(pair)]

    law = system.feedback
    chosen = system.velocities
    words: dict[str, Any] = {key: own(getattr(system, key)) for key in WORDS}
    return Mechanism(
        name,
        **words,
        collisions=within(system.collisions),
        unwatched=within(system.unwatched),
        gravity=system.gravity,
        velocities=own(chosen) if isinstance(chosen, tuple) else chosen,
        values={key: value for key, value in system.values if own([key])},
        feedback=Feedback(own(law.references), own(law.law)) if isinstance(law, Feedback) else None,
    )


def _name_in(word: Any) -> str:
    """Return a name that a word of a machine has, or that something in it has."""
    if isinstance(word, str):
        return word
    if isinstance(word, tuple):  # an entry of a law, by its name
        return _name_in(word[0])
    if isinstance(name := getattr(word, "name", None), str):
        return name
    return min(str(atom) for atom in atoms_of(word) if atom not in UP)


def _misfits(machines: Mapping[str, Mechanism]) -> Iterator[Mistake]:
    """Yield why machines cannot be one."""
    weighed = [system for system in machines.values() if system.gravity is not None]
    given = [system.gravity for system in weighed if system.gravity is not None]
    sizes = {
        (system.down, system.number(gravity.strength))
        for system, gravity in zip(weighed, given, strict=True)
    }
    for name, system in machines.items():
        where = f"machine {name!r}"
        if system.modes:
            remedy = (
                f'Plan for it alone, then for others with [[world.obstacle]] run = "runs/{name}".'
            )
            yield Mistake(where, "it has modes.", remedy)
        if system.gravity is None and any(_falls(system, gravity) for gravity in given):
            yield Mistake(where, "it has no gravity, which another one has.", "Give it some.")
    if len(sizes) > 1:
        yield Mistake("machines", "their gravity differs.", "Give all of them the same.")


def _falls(system: Mechanism, gravity: Gravity) -> bool:
    """Say whether the height of a body with mass changes."""
    places = [pose(body.frame)[1] for body in system.bodies if not body.massless]
    heights = [sum(a * b for a, b in zip(gravity.down, at, strict=True)) for at in places]
    return any(coordinate_of(part) is not None for part in parts_of(map(exact, heights)))


def _law(part: Mechanism) -> Feedback:
    """Return a machine's law of feedback; where it has none, that inputs are what is asked for."""
    if isinstance(part.feedback, Feedback):
        return part.feedback
    asked = {u: Reference(f"{u.name}_given", limit=u.limit, unit=u.unit) for u in part.inputs}
    return Feedback([*asked.values()], [(u.name, given.symbol) for u, given in asked.items()])


def _between(parts: list[Mechanism]) -> Iterator[tuple[str, str]]:
    """Yield the pairs of bodies and cables of different machines."""
    solid = [
        [body.name for body in part.bodies if body.shapes]
        + [cable.name for cable in part.cables if cable.collides]
        for part in parts
    ]
    for one, other in combinations(solid, 2):
        yield from ((a, b) for a in one for b in other)


def _velocities(parts: list[Mechanism]) -> Any:
    """Return the independent velocities of all, where some name theirs."""
    if any(part.velocities == "all" for part in parts):
        return "all"
    found: list[Any] = []
    for part in parts:
        if part.velocities is not None:
            found += part.velocities
            continue
        derived = derive(part)
        rates = [c for c in part.coordinates for _ in c.rates]
        found += [*derived.quasi, *dict.fromkeys(rates[i] for i in derived.independent)]
    return found


class _Renamed:
    """Puts a text before all names of a machine."""

    def __init__(self, prefix: str) -> None:
        self._prefix = prefix
        self._made: dict[Any, Any] = {}

    def __call__(self, system: Mechanism) -> Mechanism:
        """Return a machine with other names, in its sentences about names as well."""
        told_of: dict[str, Any] = {f.name: getattr(system, f.name) for f in fields(system)}
        plain = ("name", "values", "keep", "notes", "expected", "offers", "parameters", "flat")
        told = ("collisions", "unwatched")
        made = {k: self._part(v) for k, v in told_of.items() if k not in (*plain, *told)}
        pairs = {k: [tuple(map(self._name, p)) for p in told_of[k]] for k in told}
        values = {self._name(name): value for name, value in system.values}
        keep = [*map(self._name, system.keep)]
        notes = [(name and self._name(name), sentence) for name, sentence in system.notes]
        content = {**made, **pairs, "values": values, "keep": keep, "notes": notes}
        return Mechanism(self._name(system.name), **content)

    def _name(self, name: str) -> str:
        return self._prefix + name

    def _part(self, part: Any) -> Any:
        """Return a part of a machine, all of it renamed; the same for the same part."""
        if isinstance(part, tuple):
            return tuple(map(self._part, part))
        if isinstance(part, Feedback):
            law = [(self._name(name), self._part(value)) for name, value in part.law]
            return Feedback(self._part(part.references), law)
        if not (isinstance(part, sympy.Basic | sympy.MatrixBase) or is_dataclass(part)):
            return part
        key = id(part) if isinstance(part, sympy.MatrixBase) else part
        if key not in self._made:
            self._made[key] = self._renamed(part)
        return self._made[key]

    def _renamed(self, part: Any) -> Any:
        if isinstance(part, MachineSymbol):
            if part in UP:
                return part
            return type(part)._build(self._name(part.name), self._part(part.facts))
        if isinstance(part, sympy.Basic | sympy.MatrixBase):
            entries = part if isinstance(part, sympy.MatrixBase) else (part,)
            symbols = [s for s in parts_of(entries) if isinstance(s, MachineSymbol)]
            return part.xreplace({symbol: self._part(symbol) for symbol in symbols})
        made = object.__new__(type(part))
        for field in fields(part):
            value: Any = getattr(part, field.name, None)
            named = field.name == "name" and not isinstance(part, NAMELESS)
            object.__setattr__(made, field.name, self._name(value) if named else self._part(value))
        return made
