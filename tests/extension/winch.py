"""An input from outside the package: the speed at which two points part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

from kinolab.dynamics.language.forces import Load
from kinolab.dynamics.language.frames import Frame
from kinolab.dynamics.language.inputs import Input, Limit, Rate
from kinolab.dynamics.language.quantities import Change, apart


@dataclass(frozen=True)
class Winch(Input):
    """A winch at one frame's origin, with a taut rope to another's, for kinematic machines.

    Attributes:
        name: Its name in scenarios and files.
        between: The two frames; their origins must not coincide.
        limit: Largest speed at which the rope becomes longer or shorter, in [m/s].
    """

    _: KW_ONLY
    between: tuple[Frame, Frame]
    limit: Limit
    unit: ClassVar[str] = "m/s"

    def lowered(self) -> Sequence[Input | Load]:
        """Return the imposed velocity, that of the distance."""
        return (Rate(self.name, on=Change(apart(*self.between)), limit=self.limit),)
