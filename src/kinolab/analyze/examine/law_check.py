"""The result of checking one law on a machine."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LawCheck:
    """Result of checking one law.

    Attributes:
        law: The law that must hold.
        value: The largest violation, relative.
        limit: What rounding and finite differences explain.
        note: What was observed; of a law that is broken, what it means for the machine.
        own: Whether it is kinolab itself that is checked, by a second computation.
    """

    law: str
    value: float
    limit: float
    note: str = ""
    own: bool = False

    @property
    def holds(self) -> bool:
        """Whether the law holds."""
        return bool(self.value <= self.limit)

    def __str__(self) -> str:
        note = f": {self.note}" if self.note else ""
        if self.holds:
            return f"holds   {self.law}{note}"
        off = f"off by {self.value:.1e}, where rounding explains {self.limit:.0e}"
        return f"BROKEN  {self.law} ({off}){note}"
