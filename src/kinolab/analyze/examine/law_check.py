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
        note: What a violation would mean; or, if it holds, what was observed.
        advice: Whether it is no law, but what a scenario will have to say.
    """

    law: str
    value: float
    limit: float
    note: str
    advice: bool = False

    @property
    def holds(self) -> bool:
        """Whether the law holds."""
        return bool(self.value <= self.limit)

    def __str__(self) -> str:
        if self.advice:
            return f"note    {self.law}: {self.note}"
        verdict = "holds" if self.holds else "BROKEN"
        return f"{verdict:6}  {self.law} ({self.value:.1e}, limit {self.limit:.0e}): {self.note}"
