"""How long the plans of the default command are, beside the shortest that long runs have found.

    plan bench benchmarks/studies/durations.toml --out studies/durations
    python benchmarks/durations.py studies/durations

Prints a Markdown table of the study's rows. The best of a scenario is the shortest verified plan
of all its rows, those of long improvement included, and of ``best_known.toml``, which has
those of earlier studies: a figure to compare with, no bound.
"""

from __future__ import annotations

import argparse
import json
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from kinolab.studies.journal import first_rows, read_rows

BEST_KNOWN = Path(__file__).with_name("best_known.toml")
NEAR = 1.1  # times the best duration
EXACT = 1e-6  # goal distance in SI units below which a plan ends in the goal's centre
HEADINGS = (
    *("scenario", "solved", "checked", "in the centre", "shortest [s]", "median [s]"),
    *("longest [s]", "best known [s]", "within 10 % of it", "clock, median [s]"),
)

Row = dict[str, Any]


def table(rows: Sequence[Row], known: Mapping[str, float]) -> str:
    """Return a Markdown table with a row for each scenario, in the order of their names.

    Args:
        rows: Of the study.
        known: The shortest duration known of each scenario, in [s]; may lack some.
    """
    lines: list[Sequence[str]] = [HEADINGS, ["---"] * len(HEADINGS)]
    for name in sorted({row["scenario"] for row in rows}):
        own = [row for row in rows if row["scenario"] == name]
        lines.append([name, *_cells(own, known.get(name, float("inf")))])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cells(rows: Sequence[Row], known: float) -> Iterator[str]:
    """Yield the figures of one scenario; a plan that is not there is longer than all others."""
    own = [row for row in rows if not json.loads(row["settings"])]
    solved = [row for row in own if row["solved"]]
    found = [row["duration"] if row["solved"] else float("inf") for row in own]
    best = min((row["duration"] for row in rows if row["solved"]), default=known)
    best = min(best, known)
    yield f"{len(solved)}/{len(own)}"
    yield f"{sum(row['checked'] is True for row in solved)}/{len(solved)}"
    yield f"{sum(row['goal_distance'] < EXACT for row in solved)}/{len(solved)}"
    yield from (f"{figure:.2f}" for figure in (min(found), median(found), max(found), best))
    yield f"{sum(row['duration'] <= NEAR * best for row in solved)}/{len(own)}"
    yield f"{median(row['wall'] for row in own):.1f}"


def main() -> None:
    """Print the table of a study."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("study", type=Path, help="folder of the study")
    known = tomllib.loads(BEST_KNOWN.read_text(encoding="utf-8"))
    print(table(first_rows(read_rows(parser.parse_args().study)), known))


if __name__ == "__main__":
    main()
