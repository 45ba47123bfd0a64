"""What offers parameters: a machine's words with numbers, and the same words with symbols."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.forces import Effort
from kinolab.dynamics.symbols.symbols import Parameter
from kinolab.errors import InputError, UnknownNameError


@dataclass(frozen=True)
class Offer:
    """Something of a machine whose numbers may become parameters."""

    def parameters(self) -> tuple[tuple[Parameter, str], ...]:
        """Return what its numbers would be called, with what each is."""
        raise NotImplementedError("write it")

    def fits(self, bodies: Sequence[Body], efforts: Sequence[Effort], own: Collection[str]) -> bool:
        """Whether it is of these bodies and efforts, in which it has parameters already."""
        raise NotImplementedError("write it")

    def taken(
        self, words: Mapping[str, tuple[Any, ...]], before: Collection[str], asked: Collection[str]
    ) -> Mapping[str, tuple[Any, ...]]:
        """Return bodies, inputs and efforts with its parameters in them.

        Args:
            words: The machine's, by the names of its fields.
            before: Names of parameters that are in them already.
            asked: Names of those that shall be.
        """
        raise NotImplementedError("write it")


def offered(offers: tuple[Offer, ...]) -> dict[str, tuple[Parameter, str]]:
    """Return all parameters that are offered, each with what it is, by name."""
    return {p.name: (p, what) for offer in offers for p, what in offer.parameters()}


def taking(
    offers: tuple[Offer, ...],
    words: Mapping[str, tuple[Any, ...]],
    before: Collection[str],
    asked: Collection[str],
) -> Mapping[str, tuple[Any, ...]]:
    """Return bodies, inputs and efforts of a machine, with parameters in them.

    Args:
        offers: Its offers.
        words: Its bodies, inputs and efforts.
        before: Names of the parameters that it has.
        asked: Names of those that it shall have, too.

    Raises:
        InputError: If one is neither.
    """
    known = offered(offers)
    wrong = [UnknownNameError("parameter", n, known={*known, *before})
             for n in asked if n not in known and n not in before]  # fmt: skip
    if wrong:
        raise InputError(mistake for error in wrong for mistake in error.mistakes)
    for offer in offers:
        own = {p.name for p, _ in offer.parameters()}
        if own & {*asked} - {*before}:
            words = offer.taken(words, before, asked)
    return words
