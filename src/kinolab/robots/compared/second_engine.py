"""What another engine says of the robot in a file, joint by joint."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

from kinolab.numerics.arrays import Array


@dataclass(frozen=True)
class Held:
    """What an engine's constraints hold together, m equations.

    Attributes:
        names: Of the constraints, one for each equation.
        gaps: By how much they are open, shape (m,), in [m] or [rad].
        slopes: How they open with the rates of all joints, shape (m, nv).
    """

    names: tuple[str, ...]
    gaps: Array
    slopes: Array


class AbstractSecondEngine(ABC):
    """Another engine's model of a robot, in which every joint moves by itself.

    A joint is at its position in [rad] or [m]; a ball joint at a quaternion x, y, z, w; one that is
    free at its child's origin in its parent's axes, and a quaternion. Rates of these are the speed
    of that origin in the parent's axes, and the angular velocity in the child's.

    Attributes:
        name: What it is called.
        rates: Which entries of all nv rates each joint has that can move, by its name.
        neglected: Moments of inertia in the file that it may lack, in all, in [kg m^2].
    """

    name: str
    neglected: float = 0.0
    rates: Mapping[str, slice]

    @abstractmethod
    def forces(self, at: Mapping[str, Array], v: Array, a: Array) -> tuple[Array, Array]:
        """Return M a + c - Q, and the sizes of the terms that it is the sum of.

        M is the mass matrix, c are Coriolis and centrifugal forces, Q are weight, springs and
        viscous friction. Contacts, limits, dry friction and actuators have no part in it.

        Args:
            at: Where each joint is, by its name.
            v, a: Rates and their derivatives, shape (nv,).

        Returns:
            Both of shape (nv,), in [N m] or [N].
        """

    @abstractmethod
    def held(self, at: Mapping[str, Array]) -> Held:
        """Return what constraints hold together where the joints are at positions."""
