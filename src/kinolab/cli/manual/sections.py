"""Pages of the manual as sections: a heading, and what stands below it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from importlib.resources import files

HEADING = re.compile(r"^(#{2,3}) (.+)$")
FENCE = "```"


@dataclass(frozen=True)
class ManualSection:
    """A heading and the text below it.

    Attributes:
        level: 1 for what stands before the first heading, 2 for a group, 3 for an entry.
        title: The heading; empty at level 1.
        text: What stands below it, up to the next heading.
    """

    level: int
    title: str
    text: str

    def __str__(self) -> str:
        head = f"{'#' * self.level} {self.title}\n\n" if self.title else ""
        return f"{head}{self.text.strip()}".strip() + "\n"


def source_of(name: str) -> str:
    """Return the hand-written part of a page: prose and examples, as Markdown."""
    return files("kinolab.cli.manual").joinpath(name).read_text(encoding="utf-8")


def sections_of(text: str) -> Iterator[ManualSection]:
    """Yield the sections of a page; what looks like a heading within code is none."""
    level, title, lines, inside = 1, "", list[str](), False
    for line in text.splitlines():
        inside ^= line.startswith(FENCE)
        found = None if inside else HEADING.match(line)
        if found:
            yield ManualSection(level, title, "\n".join(lines))
            level, title, lines = len(found[1]), found[2], []
        else:
            lines.append(line)
    yield ManualSection(level, title, "\n".join(lines))


def table(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    """Return rows of cells as a Markdown table."""
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join(
        f"| {' | '.join(c.replace('|', chr(92) + '|') for c in row)} |" for row in lines
    )


def anchors_of(titles: Iterable[str]) -> list[str]:
    """Return the link to each heading of a page, as GitHub makes them: a second one is numbered."""
    met: Counter[str] = Counter()
    links = []
    for title in titles:
        name = re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
        links.append(f"#{name}-{met[name]}" if met[name] else f"#{name}")
        met[name] += 1
    return links
