"""What one notebook or project is worth."""

from __future__ import annotations

from dataclasses import dataclass

from kinolab.testing.exercises import Mark


@dataclass(frozen=True)
class Report:
    """What one notebook or project is worth.

    Attributes:
        source: The file.
        marks: Of each exercise, in order.
        errors: Cells that failed, in words.
    """

    source: str
    marks: tuple[Mark, ...]
    errors: tuple[str, ...] = ()

    @property
    def points(self) -> int:
        """What was reached."""
        return sum(mark.points for mark in self.marks)

    @property
    def of(self) -> int:
        """What there is."""
        return sum(mark.of for mark in self.marks)

    def __str__(self) -> str:
        """List the exercises, then what failed."""
        lines = [f"{self.source}: {self.points} of {self.of} points"]
        lines += [f"  {mark!r}" for mark in self.marks]
        lines += [f"  {error}" for error in self.errors]
        return "\n".join(lines)
