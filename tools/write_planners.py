"""Write the list of planners into docs/planners.md from the planners themselves.

    python tools/write_planners.py [--check]

With --check nothing is written: it shows how the page differs and returns 1 if it does. The text
around the list is written by hand.
"""

from __future__ import annotations

import argparse
import difflib
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from kinolab.cli.listing import setting_rows
from kinolab.cli.planner_entry import PlannerEntry, planner_entries
from kinolab.planners import built_in
from kinolab.scenario import shared_settings
from kinolab.settings import Setting

PAGE = Path(__file__).resolve().parents[1] / "docs" / "planners.md"
BEGIN = "<!-- written by tools/write_planners.py: begin -->"
END = "<!-- written by tools/write_planners.py: end -->"
SHARED = "Every planner has these keys of `[planner]` besides its own settings:"


def listing() -> str:
    """Return the list of kinolab's planners; those of installed packages are not part of it."""
    entries = [entry for entry in planner_entries(built_in()) if not entry.origin]
    parts = ["## The planners", SHARED, table(shared_settings())]
    for entry in entries:
        parts += section(entry)
    return "\n\n".join(parts)


def section(entry: PlannerEntry) -> Iterator[str]:
    """Yield what the page says about a planner."""
    if entry.fault:
        raise SystemExit(f"{entry.name} cannot be described here: {entry.fault}")
    yield f"### {entry.name}"
    yield entry.summary
    yield table(entry.settings) if entry.settings else "It has no settings."
    if entry.source:
        yield f"Source: {entry.source}"


def table(settings: Iterable[Setting]) -> str:
    """Return settings as a Markdown table."""
    rows: list[Sequence[str]] = [("setting", "default", "unit", "range", "meaning"), ("---",) * 5]
    for name, default, unit, values, meaning in setting_rows(settings):
        rows.append((f"`{name}`", default, unit or "–", values or "–", meaning))
    escaped = ([cell.replace("|", r"\|") for cell in row] for row in rows)
    return "\n".join(f"| {' | '.join(row)} |" for row in escaped)


def page(written: str) -> str:
    """Return the text of the page, its list made anew.

    Raises:
        ValueError: If the page lacks the marks around the list.
    """
    before, begin, rest = written.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise ValueError(f"{PAGE.name} lacks the lines {BEGIN} and {END}")
    return f"{before}{BEGIN}\n\n{listing()}\n\n{END}{after}"


def main() -> int:
    """Write the page, or check it."""
    parser = argparse.ArgumentParser(description="Write the list in docs/planners.md.")
    parser.add_argument("--check", action="store_true", help="write nothing, show what differs")
    options = parser.parse_args()
    written = PAGE.read_text(encoding="utf-8")
    text = page(written)
    if not options.check:
        PAGE.write_text(text, encoding="utf-8")
        return 0
    before, after = written.splitlines(keepends=True), text.splitlines(keepends=True)
    sys.stdout.writelines(difflib.unified_diff(before, after, PAGE.name, "as it should be"))
    return 0 if text == written else 1


if __name__ == "__main__":
    sys.exit(main())
