"""What came of a study as Markdown tables and as one JSON object."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from .records import ACCEPTED, RAISED, REFUSED, Record

HEADINGS = ("faults", "really false", "of them accepted", "true after all", "borderline", "unknown")
LEGEND = """\
- *really false*: by the judge, who shares nothing with the verifier; *of them accepted* must be 0.
- *true after all*: the fault changes nothing that counts, such as rows left out between equal
  inputs; how many of these the verifier refused is in brackets.
- *borderline*: within a factor of two of a tolerance. *unknown*: the judge has no equations; none
  of them may be accepted."""
GOOD = ("plans", "true by the judge", "refused")


def row(records: Sequence[Record]) -> list[str]:
    """Return the figures of some false plans."""
    truths = Counter(record.truth for record in records)
    false = [record for record in records if record.truth == "false"]
    accepted = sum(record.answer != REFUSED for record in false)
    true = [record for record in records if record.truth == "true"]
    refused = sum(record.answer == REFUSED for record in true)
    unknown = [record for record in records if record.truth == "unknown"]
    let_in = sum(record.answer == ACCEPTED for record in unknown)
    return [
        str(len(records)),
        str(len(false)),
        f"**{accepted}**" if accepted else "0",
        f"{len(true)} ({refused})" if refused else str(len(true)),
        str(truths["borderline"]),
        f"{len(unknown)} (**{let_in}** accepted)" if let_in else str(len(unknown)),
    ]


def good_row(records: Sequence[Record]) -> list[str]:
    """Return the figures of some good plans."""
    true = sum(record.truth == "true" for record in records)
    refused = sum(record.answer != ACCEPTED for record in records)
    return [str(len(records)), str(true), f"**{refused}**" if refused else "0"]


def table(
    records: Iterable[Record],
    by: Sequence[tuple[str, Callable[[Record], str]]],
    headings: Sequence[str],
    figures: Callable[[Sequence[Record]], list[str]],
) -> str:
    """Return one table, a row for each combination of some names, and one of all."""
    groups: dict[tuple[str, ...], list[Record]] = {}
    for record in records:
        groups.setdefault(tuple(name(record) for _, name in by), []).append(record)
    every = [record for group in groups.values() for record in group]
    titles = [title for title, _ in by]
    lines = [
        "| " + " | ".join([*titles, *headings]) + " |",
        "|" + " --- |" * len(titles) + " ---: |" * len(headings),
        *("| " + " | ".join([*key, *figures(groups[key])]) + " |" for key in sorted(groups)),
        "| " + " | ".join(["**all**", *[""] * (len(by) - 1), *figures(every)]) + " |",
    ]
    return "\n".join(lines)


def machine(record: Record) -> str:
    """Return a record's machine."""
    return record.machine


def kind(record: Record) -> str:
    """Return a record's kind."""
    return record.kind


def text(false: list[Record], good: list[Record], files: list[Record]) -> str:
    """Return all tables, and what went wrong in detail."""
    parts = [
        "### False plans, by kind of fault",
        table(false, [("fault", kind)], HEADINGS, row),
        "### False plans, by machine",
        table(false, [("machine", machine)], HEADINGS, row),
        "### False plans, by machine and kind of fault",
        table(false, [("machine", machine), ("fault", kind)], HEADINGS, row),
        LEGEND,
        "### Edited files of runs",
        table(files, [("edit", kind)], HEADINGS, row),
        "### Good plans",
        table(good, [("written", kind)], GOOD, good_row),
        table(good, [("machine", machine)], GOOD, good_row),
        "### What went wrong",
        "\n".join(wrong([*false, *let_in(files)], good)) or "Nothing.",
    ]
    return "\n\n".join(parts) + "\n"


def let_in(files: Sequence[Record]) -> list[Record]:
    """Return the edits that were not refused; to refuse any edited file is right."""
    return [record for record in files if record.answer != REFUSED]


def wrong(false: Sequence[Record], good: Sequence[Record]) -> list[str]:
    """Return a line for each false plan that was accepted and each good one that was refused."""
    bad = [record for record in false if record.wrong]
    bad += [record for record in good if record.answer != ACCEPTED or record.truth == "false"]
    return [
        f"- {one.number}, {one.plan}, {one.kind}: {one.what}; the judge: {one.truth} ({one.why});"
        f" the verifier: {one.answer} ({', '.join(one.checks)})"
        for one in bad
    ]


def as_json(false: list[Record], good: list[Record], files: list[Record]) -> str:
    """Return the counts by machine, kind, truth and answer."""

    def counts(records: list[Record]) -> list[dict[str, Any]]:
        found = Counter((r.machine, r.kind, r.truth, r.answer) for r in records)
        names = ("machine", "kind", "truth", "answer")
        return [
            {**dict(zip(names, key, strict=True)), "count": count}
            for key, count in sorted(found.items())
        ]

    accepted = sum(one.truth == "false" and one.answer != REFUSED for one in [*false, *files])
    refused = sum(one.answer in (REFUSED, RAISED) for one in good)
    whole = {
        "false_plans": len(false),
        "really_false": sum(one.truth == "false" for one in false),
        "edited_files": len(files),
        "false_accepted": accepted,
        "good_plans": len(good),
        "good_refused": refused,
        "by_fault": counts(false),
        "by_edit": counts(files),
        "by_good": counts(good),
    }
    return json.dumps(whole, indent=1) + "\n"
