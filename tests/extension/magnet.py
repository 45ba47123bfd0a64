"""A force from outside the package: two magnets that are small beside their distance.

Source: Griffiths, Introduction to Electrodynamics, 4th ed., 2013, problem 6.21: the energy of two
dipoles, mu_0 / (4 pi r^3) (m_1 . m_2 - 3 (m_1 . r) (m_2 . r) / r^2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy

from kinolab.dynamics.language.forces import Effort, Load, Potential
from kinolab.dynamics.language.frames import Frame, Number, move
from kinolab.dynamics.language.quantities import place

PERMEABILITY = 1e-7  # mu_0 / (4 pi) in [N / A^2]


@dataclass(frozen=True, kw_only=True)
class Magnets(Effort):
    """Two magnetic dipoles at the origins of two frames, along their z axes.

    Attributes:
        between: The two frames; their origins must not coincide.
        moments: In [A m^2].
    """

    between: tuple[Frame, Frame]
    moments: tuple[Number, Number]

    def lowered(self) -> Sequence[Potential | Load]:
        """Return their energy."""
        one, other = self.between
        path = place(other) - place(one)
        axes = (place(frame @ move(0, 0, 1)) - place(frame) for frame in self.between)
        a, b = (moment * axis for moment, axis in zip(self.moments, axes, strict=True))
        r = sympy.sqrt(path.dot(path))
        energy = a.dot(b) / r**3 - 3 * a.dot(path) * b.dot(path) / r**5
        return (Potential(PERMEABILITY * energy),)
