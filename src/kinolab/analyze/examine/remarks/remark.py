"""What ``plan examine`` has to remark on a machine, and how its author says that it is meant so."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Remark:
    """Something about a machine that is hardly ever meant.

    Attributes:
        kind: What it is, in a few words: ``no rolling constraint``.
        about: On which part of the machine: ``ball``.
        sentence: What was found and what would be right.
        part: The word of the language that made that part, and its name, by which its line is found
            in a file: ``("Body", "ball")``.
        place: That line, ``ball_beam.py, line 22``; empty where the file is not known.
    """

    kind: str
    about: str
    sentence: str
    part: tuple[str, str]
    place: str = ""

    @property
    def title(self) -> str:
        """What it is and on what; ``expected=`` takes this, or its kind alone."""
        return f"{self.kind}: {self.about}" if self.about else self.kind

    def __str__(self) -> str:
        where = f" ({self.place})" if self.place else ""
        return f"{self.title}{where}. {self.sentence}"


def sorted_out(
    remarks: Iterable[Remark], expected: Sequence[str]
) -> tuple[tuple[Remark, ...], tuple[str, ...]]:
    """Leave out the remarks that a machine's author expects.

    Args:
        remarks: All that were found.
        expected: Kinds or titles of remarks.

    Returns:
        What is left, and the entries of ``expected`` that no remark answers to.
    """
    found = tuple(dict.fromkeys(remarks))
    left = tuple(one for one in found if not {one.kind, one.title} & set(expected))
    named = {name for one in found for name in (one.kind, one.title)}
    return left, tuple(entry for entry in expected if entry not in named)
