"""``Mechanism``: a machine as data, with bodies, constraints, forces and inputs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import groupby
from typing import Any, Literal, Self

from kinolab.arguments import checked
from kinolab.dynamics.language.bodies import AnyCable, Body, as_cables
from kinolab.dynamics.language.constraints import Constraint, Requirement, closed
from kinolab.dynamics.language.feedback import Feedback, Regulator
from kinolab.dynamics.language.flatness import Flat
from kinolab.dynamics.language.forces import Effort, Gravity
from kinolab.dynamics.language.inputs import Input
from kinolab.dynamics.language.mechanism_parts import (
    AnyCoordinate,
    MechanismParts,
    atoms_of,
    coordinate_of,
)
from kinolab.dynamics.language.modes import MODE, Mode, Transition
from kinolab.dynamics.language.offer import Offer, taking
from kinolab.dynamics.language.quasi_velocities import QuasiVelocity, State
from kinolab.dynamics.language.validation import mistakes_of
from kinolab.dynamics.symbols.symbols import Coordinate, Parameter
from kinolab.errors import InputError, Mistake, listed


@checked
@dataclass(frozen=True, init=False)
class Mechanism(MechanismParts):
    """A mechanical system, immutable; it may consist of several separate mechanisms.

    Args:
        name: Its name in scenarios.
        bodies: Everything with mass or shape.
        constraints: Enforced by forces: ``zero(velocity)``, ``closed(position)``.
        inputs: Control inputs, in this order.
        efforts: Other forces: springs, ropes, friction, buoyancy, wrenches.
        gravity: Uniform gravity, if any; it also defines up in renderings.
        states: Auxiliary states with differential equations of their own.
        requirements: Path constraints on plans: ``require(margin, name)``.
        collisions: Pairs of bodies or cables that may not touch each other, by name.
        unwatched: Further pairs that can touch, of which ``plan`` says so; readers of robots' files
            know some.
        notes: Sentences on names that it does not have, such as those of joints that follow others;
            under the name ``""`` on what of a robot's file is not read.
        cables: Ropes and strings; a pair of frames stands for a ``Cable`` between them.
        velocities: Coordinates whose rates are the independent velocities, and quasi-velocities
            such as ``QuasiVelocity("v", V.x)``. When left out, kinolab takes rates where they
            determine all velocities over the coordinates' whole range, else velocities of frames
            along their axes. ``"all"`` keeps every rate as a state and solves for the constraint
            forces as multipliers, for machines where no fixed choice is valid everywhere.
        coordinates: Order of the coordinates; by default that of their creation.
        values: Parameter values other than the defaults, by name.
        keep: Names of parameters that are exact, such as the height of a bar: ``plan execute``
            does not vary them by itself.
        flat: Flatness description, if the machine is flat; used by steering.
        feedback: Controller that is part of the machine, if any: planners then choose its
            references, which determine the inputs.
        modes: What holds in each mode of a machine whose mechanics switch; its first state begins
            in the first one. Its state has an entry ``mode``, the mode's place in this list.
        transitions: How modes end, and what follows.
        expected: Remarks of ``plan examine`` that are meant as they are: what stands before their
            colon, ``"no rolling constraint"``, or also what they are about, ``"no rolling
            constraint: ball"``. It leaves these out.
        offers: What has numbers that become parameters once one asks for them.

    Raises:
        InputError: With every mistake in the description.
    """

    def __init__(
        self,
        name: str,
        *,
        bodies: Sequence[Body],
        constraints: Sequence[Constraint] = (),
        inputs: Sequence[Input] = (),
        efforts: Sequence[Effort] = (),
        gravity: Gravity | None = None,
        states: Sequence[State] = (),
        requirements: Sequence[Requirement] = (),
        collisions: Sequence[tuple[str, str]] = (),
        unwatched: Sequence[tuple[str, str]] = (),
        notes: Sequence[tuple[str, str]] = (),
        cables: Sequence[AnyCable] = (),
        velocities: Sequence[AnyCoordinate | QuasiVelocity] | Literal["all"] | None = None,
        coordinates: Sequence[AnyCoordinate] | None = None,
        values: Mapping[str, Any] | None = None,  # validated with their parameters
        keep: Sequence[str | Parameter] = (),
        flat: Flat | None = None,
        feedback: Feedback | Regulator | None = None,
        modes: Sequence[Mode] = (),
        transitions: Sequence[Transition] = (),
        expected: Sequence[str] = (),
        offers: Sequence[Offer] = (),
    ) -> None:
        content = {
            "bodies": tuple(bodies),
            "constraints": tuple(constraints),
            "inputs": tuple(inputs),
            "efforts": tuple(efforts),
            "gravity": gravity,
            "states": _with_mode(tuple(states), len(modes)),
            "requirements": tuple(requirements),
            "cables": as_cables(tuple(cables)),
            "feedback": feedback,
            "modes": tuple(modes),
            "transitions": tuple(transitions),
        }
        atoms = set(atoms_of(tuple(content.values())))
        used = {a for a in map(coordinate_of, atoms) if a is not None}
        lengths = tuple(_unit_lengths(used))
        known = {constraint.name for constraint in constraints}
        content["constraints"] = (*constraints, *(c for c in lengths if c.name not in known))
        if lengths and velocities is None:
            velocities = "all"  # no two rates of a direction determine the third everywhere
        vars(self).update(
            content,
            name=name,
            collisions=tuple((a, b) for a, b in collisions),
            unwatched=tuple((a, b) for a, b in unwatched),
            notes=tuple((name, sentence) for name, sentence in notes),
            velocities=velocities
            if velocities is None or isinstance(velocities, str)
            else tuple(velocities),
            coordinates=tuple(
                sorted(used, key=lambda c: c.serial) if coordinates is None else coordinates
            ),
            parameters=tuple(sorted((a for a in atoms if isinstance(a, Parameter)), key=str)),
            values=tuple(sorted((values or {}).items())),
            keep=tuple(map(str, keep)),
            flat=flat,
            expected=tuple(expected),
            offers=tuple(offers),
        )
        mistakes = list(mistakes_of(self, atoms, used))
        if mistakes:
            raise InputError(mistakes)

    def __repr__(self) -> str:
        """Name it, its coordinates and its inputs, on one line."""
        chosen = {"of": self.coordinates, "driven by": self.inputs}
        told = (f"{how} {listed(one.name for one in own)}" for how, own in chosen.items() if own)
        return f"<{type(self).__name__} {self.name}: {'; '.join(told)}>"

    @classmethod
    def of(cls, other: Mechanism) -> Self:
        """Return a machine as one of this class."""
        return cls(**other._content())

    def with_parameters(self, **values: float) -> Self:
        """Return the same machine with other parameter values, without deriving again.

        Numbers that it offers become parameters where they are given other values.

        Raises:
            InputError: If a parameter does not exist or a value is not a number.
        """
        own, offered = {p.name for p in self.parameters}, self.offered
        same = {n for n, v in values.items() if n not in own and offered.get(n) == v}
        given = {name: value for name, value in values.items() if name not in same}
        asked = [name for name in given if name in offered]
        made = self.parametric(*asked) if asked else self
        return made.changed(values=dict(self.values) | given)

    def parametric(self, *names: str) -> Self:
        """Return the same machine with numbers that it offers as parameters, such as ``m_hand``.

        Args:
            names: What they are called, of a robot ``plan describe`` lists them; none for all.

        Raises:
            InputError: If it does not offer one.
        """
        own = [p.name for p in self.parameters]
        words = {name: getattr(self, name) for name in ("bodies", "inputs", "efforts")}
        asked = [name for name in names or self.offered if name not in own]
        return self.changed(**taking(self.offers, words, own, asked)) if asked else self

    def with_feedback(self, feedback: Feedback | Regulator | None) -> Self:
        """Return the same machine with another controller, or with none.

        Raises:
            InputError: If the controller does not fit the machine.
        """
        return self.changed(feedback=feedback)

    def changed(self, **content: Any) -> Self:
        """Return the same machine with other arguments of its constructor.

        Raises:
            InputError: With every mistake in the description.
        """
        return type(self)(**self._content() | content)

    def _content(self) -> dict[str, Any]:
        """Return the constructor's arguments; parameters are collected from the rest."""
        own = {field.name: getattr(self, field.name) for field in fields(self)}
        del own["parameters"]
        return own | {"values": dict(self.values)}


def _unit_lengths(used: Iterable[AnyCoordinate]) -> Iterator[Constraint]:
    """Yield the constraint that a direction's entries make a unit vector, for each direction."""
    spheres = (c for c in used if isinstance(c, Coordinate) and c.topology == "sphere")
    for stem, entries in groupby(sorted(spheres, key=str), lambda c: c.name[:-2]):
        own = list(entries)
        if len(own) < 3:
            what, remedy = "one of its entries does not occur.", "Use all three, or an angle."
            raise InputError([Mistake(f"direction {stem!r}", what, remedy)])
        yield closed((sum(entry**2 for entry in own) - 1) / 2, f"length of {stem}")


def _with_mode(states: tuple[State, ...], modes: int) -> tuple[State, ...]:
    """Return the states of a machine with some modes: the last one says which it is in."""
    if not modes or any(entry.name == MODE for entry in states):
        return states
    last = max(modes - 1.0, 0.5)  # limits must differ, and 0.5 is the first mode still
    return (*states, State(MODE, 0, limits=(0.0, last)))
