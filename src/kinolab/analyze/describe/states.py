"""The state space of a machine: its dimension, components and storage."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from kinolab.dynamics import System


@dataclass(frozen=True)
class StateStorage:
    """Dimensions of a state space by kind, and its storage.

    Attributes:
        positions: Dimension of the configurations under holonomic constraints.
        velocities: Independent velocities that are states.
        further: Names of the states with their own differential equations.
        stored: Length of the stored state vector.
        lengths: How many of its entries are fixed by the unit length of a quaternion.
    """

    positions: int
    velocities: int
    further: tuple[str, ...]
    stored: int
    lengths: int

    @property
    def dimension(self) -> int:
        """Of the state space, a manifold."""
        return self.positions + self.velocities + len(self.further)

    @property
    def held(self) -> int:
        """How many of the stored numbers are fixed by constraints."""
        return self.stored - self.lengths - self.dimension

    def parts(self) -> str:
        """Describe the dimensions."""
        counts = {
            f"{self.positions} of position": self.positions,
            f"{self.velocities} of velocity": self.velocities,
            f"{len(self.further)} further ({', '.join(self.further)})": len(self.further),
        }
        return ", ".join(text for text, count in counts.items() if count)

    def storage(self) -> str:
        """Describe the storage if it takes more numbers than the dimension; else empty."""
        reasons = list(self._reasons())
        return f"stored as {self.stored} numbers: {' and '.join(reasons)}" if reasons else ""

    def _reasons(self) -> Iterator[str]:
        if self.lengths:
            owner = "a unit quaternion fixes" if self.lengths == 1 else "unit quaternions fix"
            yield f"{owner} {self.lengths} of them"
        if self.held:
            yield f"constraints fix {self.held} of them"


def state_storage(
    system: System, *, dimension: int, stored: int, redundant: Sequence[str]
) -> StateStorage:
    """Return the dimensions of a state space by kind.

    Args:
        dimension: Of its state space.
        stored: Numbers that a state is stored as.
        redundant: Names of constraints that follow from others.
    """
    lengths = sum(len(c.entries) - len(c.rates) for c in system.coordinates)
    held = sum(closure.name not in redundant for closure in system.closures)
    positions = sum(len(c.rates) for c in system.coordinates) - held
    further = tuple(entry.name for entry in system.states)
    velocities = dimension - positions - len(further)
    return StateStorage(positions, velocities, further, stored, lengths)
