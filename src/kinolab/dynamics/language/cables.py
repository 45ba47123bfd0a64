"""Cables: taut ropes and strings as capsules between the origins of two frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from kinolab.arguments import checked
from kinolab.dynamics.language.frames import Frame
from kinolab.dynamics.language.shapes import Scalar
from kinolab.errors import InputError, Mistake


@checked
@dataclass(frozen=True)
class Cable:
    """A taut rope, string or chain: a capsule between the origins of two frames.

    It has neither mass nor force of its own; coordinates, constraints and inputs define its effect.
    It collides with obstacles, not with the ground, and with bodies and cables of its machine only
    where ``System(collisions=…)`` pairs them.

    Attributes:
        between: The frames of its ends, at any distance.
        name: Its name in contacts; numbered by the system when left out.
        radius: In [m], a number or an expression in parameters.
        collides: Whether it takes part in collision checks; otherwise it is only drawn.
    """

    between: tuple[Frame, Frame] | list[Frame]
    name: str = ""
    radius: Scalar = 0.01
    collides: bool = True

    def __post_init__(self) -> None:
        """Validate that there are two ends; a list of two is accepted."""
        if len(self.between) != 2:
            what = f"it has {len(self.between)} ends."
            remedy = "Give a pair, such as (trolley.frame, load.frame)."
            raise InputError([Mistake(f"Cable {self.name!r} between", what, remedy)])
        object.__setattr__(self, "between", tuple(self.between))


AnyCable: TypeAlias = Cable | tuple[Frame, Frame] | list[Frame]


def as_cables(entries: Sequence[AnyCable]) -> tuple[Cable, ...]:
    """Convert pairs of frames to cables, and number unnamed ones."""
    return tuple(_named(entry, k, len(entries)) for k, entry in enumerate(entries))


def _named(entry: Any, k: int, count: int) -> Cable:
    cable = entry if isinstance(entry, Cable) else Cable(entry)
    return cable if cable.name else replace(cable, name=f"cable {k + 1}" if count > 1 else "cable")
