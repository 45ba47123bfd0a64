"""The friction of a joint, whose coefficients become parameters."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.forces import Coulomb, Effort, Viscous
from kinolab.dynamics.language.frames import Number
from kinolab.dynamics.language.offer import Offer
from kinolab.dynamics.symbols.symbols import Parameter

BEGINNINGS = ("d", "f")  # of parameters' names


@checked
@dataclass(frozen=True)
class JointFriction(Offer):
    """The friction of a joint, of which each rate has the same.

    Attributes:
        name: What its parameters are called after.
        rates: Of its coordinates.
        damping: Viscous friction in [N m s/rad] or [N s/m], then the coefficients of v |v|, ….
        friction: Coulomb friction in [N m] or [N].
        turns: Whether it turns; otherwise it slides.
    """

    name: str
    rates: tuple[Number, ...]
    damping: tuple[float, ...]
    friction: float
    turns: bool

    def parameters(self) -> tuple[tuple[Parameter, str], ...]:
        """Return both coefficients."""
        name = self.name
        viscous, dry = ("N m s/rad", "N m") if self.turns else ("N s/m", "N")
        return (
            (Parameter(f"d_{name}", self.damping[0], viscous), f"damping of {name}"),
            (Parameter(f"f_{name}", self.friction, dry), f"dry friction of {name}"),
        )

    def efforts(self, asked: Collection[str] = ()) -> Iterator[Effort]:
        """Yield the forces, with parameters where they are asked for."""
        first, dry = (p if p.name in asked else p.default for p, _ in self.parameters())
        damping = first, *self.damping[1:]
        for own in self.rates:
            if any(damping):
                terms = (c * sympy.Abs(own) ** k for k, c in enumerate(damping) if c)
                yield Viscous(own, sympy.Add(*terms))
            if dry:
                yield Coulomb(own, dry)

    def fits(
        self,
        bodies: Sequence[Body],  # noqa: ARG002 - it is of efforts
        efforts: Sequence[Effort],
        own: Collection[str],
    ) -> bool:
        """Whether the forces are there."""
        return all(effort in efforts for effort in self.efforts(own))

    def taken(
        self, words: Mapping[str, tuple[Any, ...]], before: Collection[str], asked: Collection[str]
    ) -> Mapping[str, tuple[Any, ...]]:
        """Return the words with other forces of friction."""
        left = list(words["efforts"])
        for effort in self.efforts(before):
            left.remove(effort)
        return {**words, "efforts": (*left, *self.efforts([*before, *asked]))}
