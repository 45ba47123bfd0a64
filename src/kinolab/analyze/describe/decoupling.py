"""Decoupling vector fields of a machine, for its description."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from kinolab.dynamics import System
from kinolab.dynamics.analysis.decoupling_fields import decoupling_fields
from kinolab.dynamics.analysis.fields.growth_vectors import filtration
from kinolab.dynamics.language.inputs import bounds_of
from kinolab.errors import InputError, a_few, counted


@dataclass(frozen=True)
class Decoupling:
    """What decoupling vector fields do for a machine with fewer inputs than velocities.

    Attributes:
        moved: Names of the coordinates that each field changes, by the field's name; empty if there
            are no decoupling fields.
        growth: Dimensions that their brackets span in the configuration space.
        dimension: Of the configurations that constraints leave.
        damped: Fields along which friction acts where no input does.
        together: Whether they may be followed at the same time.
        one_way: Inputs that cannot push both ways, with their limits: what they set going, nothing
            stops.
    """

    moved: dict[str, tuple[str, ...]]
    growth: tuple[int, ...]
    dimension: int
    damped: tuple[str, ...]
    together: bool
    one_way: tuple[str, ...] = ()

    @property
    def controllable(self) -> bool:
        """Whether paths along the fields lead to every configuration near by."""
        spanned = bool(self.growth) and self.growth[-1] == self.dimension
        return spanned and not self.one_way

    def sentences(self) -> Iterator[str]:
        """Yield what it means, in sentences."""
        if not self.moved:
            yield "It has no decoupling vector field: no direction that it can follow at any speed."
            return
        fields = counted(len(self.moved), "decoupling vector field")
        named = (f"{name} (moves {', '.join(moved)})" for name, moved in self.moved.items())
        yield f"It has {fields}: {a_few(named, between='; ')}. {self._followed()}"
        growth, whole = ", ".join(map(str, self.growth)), self.dimension
        reached = f"Their brackets span ({growth}) of {whole} dimensions of the configuration space"
        if self.growth[-1] < whole:
            yield f"{reached}: paths along them do not lead everywhere."
        elif self.one_way:
            yield f"{reached}."
        else:
            yield f"{reached}: paths along them lead everywhere (kinematically controllable)."

    def _followed(self) -> str:
        """Say how the machine can follow the fields, and what friction does about it."""
        verb = "could" if self.damped or self.one_way else "can"
        which = "it" if len(self.moved) == 1 else "them and all their combinations"
        if len(self.moved) > 1 and not self.together:
            which = "them, one at a time,"
        text = f"it {verb} follow {which} with any time scaling, from rest to rest"
        if self.one_way:
            do = "does" if len(self.one_way) == 1 else "do"
            return f"If every input pushed both ways, {text}; {', '.join(self.one_way)} {do} not."
        if not self.damped:
            return f"{text[0].upper()}{text[1:]}."
        named = ", ".join(self.damped)
        return f"Without friction {text}; along {named}, friction acts where no input does."


def decoupling_of(system: System, dimension: int) -> Decoupling | None:
    """Return the decoupling fields of a machine; None if the notion does not apply to it.

    Args:
        system: A machine whose inputs push along fewer directions than its velocities have.
        dimension: Of the configurations that constraints leave.
    """
    try:
        found = decoupling_fields(system)
    except InputError:
        return None
    if not found.names:
        return Decoupling({}, (), dimension, (), together=False)
    growth = filtration(found.fields).growth
    limits = [(entry, *bounds_of(entry)) for entry in system.inputs]
    one_way = tuple(
        f"{entry.name} ({lower:g} to {upper:g} {entry.unit})"
        for entry, lower, upper in limits
        if not lower < 0.0 < upper
    )
    moved = dict(found.moved)
    return Decoupling(moved, growth, dimension, found.damped, found.together, one_way)
