"""A motion from the start, as far as it was found."""

from __future__ import annotations

from dataclasses import dataclass, field

from kinolab.numerics.arrays import Array


@dataclass(eq=False)
class PartialMotion:
    """States and the inputs between them, from the start.

    Attributes:
        states: The first is the start.
        inputs: One fewer than the states.
    """

    states: list[Array]
    inputs: list[Array] = field(default_factory=list)

    @property
    def end(self) -> Array:
        """The state it leads to."""
        return self.states[-1]

    def until(self, count: int) -> PartialMotion:
        """Return the part of it that has ``count`` inputs."""
        return PartialMotion(self.states[: count + 1], self.inputs[:count])

    def add(self, u: Array, x: Array) -> None:
        """Go on with inputs that lead to a state."""
        self.inputs.append(u)
        self.states.append(x)
