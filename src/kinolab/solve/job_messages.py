"""What a process that searches tells the one that started it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from kinolab.solve.plan import Plan


@dataclass(frozen=True)
class Searching:
    """How far it is, in all its searches together."""

    iterations: int
    seconds: float


@dataclass(frozen=True)
class Better:
    """It has a verified plan, the best one so far with this seed, and goes on to improve it."""

    plan: Plan


@dataclass(frozen=True)
class Found:
    """A search is over."""

    plan: Plan
    after: float  # [s] since its first search began


@dataclass(frozen=True)
class Failed:
    """It cannot go on."""

    exit_code: int
    reason: str


Message: TypeAlias = Searching | Better | Found | Failed
