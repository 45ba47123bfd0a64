"""What is said between the process that wants a film and the one that draws it."""

from __future__ import annotations

from dataclasses import dataclass

from kinolab.show.film.staging.script import Script


@dataclass(frozen=True)
class Order:
    """A film to draw; it takes the place of those that were not begun, whose obstacles stay.

    Only the first order has obstacles, which are large and the same in all.
    """

    number: int
    script: Script


@dataclass(frozen=True)
class Final:
    """The film that was ordered last is waited for: no other one will be, and nothing else runs."""


@dataclass(frozen=True)
class Compiling:
    """An inner loop is being compiled."""

    functions: int
    seconds: float


@dataclass(frozen=True)
class Drawn:
    """What came of an order.

    Args:
        content: The finished file; None where drawing has failed.
        reason: The traceback of a failure; empty where memory was short.
    """

    number: int
    content: bytes | None
    reason: str = ""
