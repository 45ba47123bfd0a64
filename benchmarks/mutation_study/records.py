"""What came of each false plan and of each good one, as lines of a file."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

REFUSED, ACCEPTED, RAISED = "refused", "accepted", "raised"


@dataclass(frozen=True)
class Record:
    """One plan and its verdicts.

    Attributes:
        number: Of the plan; it decides all random numbers.
        machine: Its name.
        kind: Of fault, or of good plan.
        plan: The plan that it was made of.
        what: The fault in words.
        truth: The judge's verdict: ``false``, ``true``, ``borderline`` or ``unknown``.
        why: What the judge found.
        answer: The verifier's: ``refused``, ``accepted``, or ``raised`` with an error of its own.
        checks: Those that failed, or the error.
        seconds: That the verifier took.
    """

    number: int
    machine: str
    kind: str
    plan: str
    what: str
    truth: str
    why: str
    answer: str
    checks: tuple[str, ...]
    seconds: float

    @property
    def wrong(self) -> bool:
        """Whether something false was accepted, something true refused, or neither was said."""
        bad = {("false", ACCEPTED), ("true", REFUSED), ("unknown", ACCEPTED)}
        return self.answer == RAISED or (self.truth, self.answer) in bad


def append(file: Path, records: Iterable[Record]) -> None:
    """Add lines to a file, whole ones."""
    text = "".join(json.dumps(asdict(record)) + "\n" for record in records)
    with file.open("a", encoding="utf-8") as out:
        out.write(text)


def read(file: Path) -> list[Record]:
    """Return all records of a file; one that was cut off in the middle is left out."""
    found: list[Record] = []
    if not file.exists():
        return found
    for line in file.read_text(encoding="utf-8").splitlines():
        try:
            entry: dict[str, Any] = json.loads(line)
        except ValueError:
            continue
        found.append(Record(**{**entry, "checks": tuple(entry["checks"])}))
    return found
