"""What others published for the benchmark's problems."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

FILE = Path(__file__).with_name("published.toml")
IDBASTAR = "iDb-A*"
PLANNERS = (IDBASTAR, "RRT*+TO", "SST*")


@dataclass(frozen=True)
class Published:
    """Figures of one planner on one problem; None where none was published.

    Attributes:
        success: Share of runs that succeeded within 120 s.
        time: Median time of the first solution in [s].
        first: Median cost of the first solution in [s].
        final: Median cost after 120 s, in [s].
    """

    success: float
    time: float | None = None
    first: float | None = None
    final: float | None = None

    def __str__(self) -> str:
        if self.time is None:
            return f"{self.success:g}, –"
        return f"{self.success:g}, {self.time:g}, {self.first:g}, {self.final:g}"


@dataclass(frozen=True)
class Others:
    """Figures of all planners on one problem.

    Attributes:
        by: Figures by the planner's name.
        best: The lowest cost of any solution that was published or stored, in [s].
    """

    by: dict[str, Published]
    best: float


def published() -> dict[str, Others]:
    """Return the figures of all 43 problems, by their names, such as ``car1_v0/kink_0``."""
    tables = tomllib.loads(FILE.read_text(encoding="utf-8"))
    return {
        name: Others({who: Published(**table[who]) for who in PLANNERS}, table["best"])
        for name, table in tables.items()
    }
