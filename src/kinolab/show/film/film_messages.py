"""What is said between the process that wants a film and the one that draws it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from kinolab.show.film.picture import Surface
from kinolab.show.film.staging.script import Script


@dataclass(frozen=True)
class Scenery:
    """The obstacles in all films that follow."""

    obstacles: Sequence[Surface]


@dataclass(frozen=True)
class Order:
    """A film to draw, without obstacles; it takes the place of those that were ordered before."""

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
    """The finished file of an order."""

    number: int
    content: bytes


@dataclass(frozen=True)
class DrawingFailed:
    """Drawing has failed."""

    number: int
    reason: str
    of_memory: bool
