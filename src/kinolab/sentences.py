"""Rows of words in sentences, and numbers of things: of many, a few are named."""

from __future__ import annotations

from collections.abc import Iterable

LINE_WIDTH = 100  # characters of a line of text, as a terminal shows it


def counted(count: int, noun: str) -> str:
    """Return ``1 field`` or ``2 fields``."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def row_of(words: Iterable[object], last: str = "and") -> str:
    """Return ``a, b and c``."""
    *first, end = [str(word) for word in words] or [""]
    return f"{', '.join(first)} {last} {end}" if first else end


def a_few(words: Iterable[object], most: int = 4, between: str = ", ") -> str:
    """Return the first words, and how many more there are: ``a, b, c, d and 2 more``."""
    names = [str(word) for word in words]
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return between.join(names[:most]) + more
