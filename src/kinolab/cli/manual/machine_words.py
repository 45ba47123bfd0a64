"""The page on machines: each word of ``kinolab.dynamics`` with its docstring and an example."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from enum import EnumMeta
from textwrap import fill
from typing import Any, get_args

import kinolab.dynamics
from kinolab.cli.manual.docstrings import markdown, members_of, signature
from kinolab.cli.manual.sections import ManualSection, anchors_of, sections_of, source_of
from kinolab.errors import LINE_WIDTH

SOURCE = "machines.md"
CONTENTS = "## Coordinates and parameters"  # the groups of words are listed before the first one


def page() -> str:
    """Return the page on machines."""
    sections = list(sections_of(source_of(SOURCE)))
    parts = [str(described(section)) for section in sections]
    first = next(k for k, section in enumerate(sections) if str(section).startswith(CONTENTS))
    return "\n".join([*parts[:first], contents(sections), *parts[first:]])


def words() -> frozenset[str]:
    """Return the words that machines are described with."""
    return frozenset(kinolab.dynamics.__all__)


def contents(sections: list[ManualSection]) -> str:
    """Return the groups of words, a line each, with links."""
    groups: dict[str, list[str]] = {}
    titled = [section for section in sections if section.title]
    for section, link in zip(titled, anchors_of(s.title for s in titled), strict=True):
        if section.level == 2:
            groups[section.title] = []
        elif section.title in words():
            [*groups.values()][-1].append(f"[`{section.title}`]({link})")
    return "".join(f"- {group}: {', '.join(links)}\n" for group, links in groups.items() if links)


def described(section: ManualSection) -> ManualSection:
    """Return a section about a word with what its docstring says, any other as it is."""
    if section.level != 3 or section.title not in words():
        return section
    told = "\n\n".join(filter(None, facts(section.title)))
    return ManualSection(section.level, section.title, f"{told}\n\n{section.text.strip()}")


def facts(word: str) -> Iterator[str]:
    """Yield what the code says about a word: how it is written, what it takes, what it has."""
    thing = getattr(kinolab.dynamics, word)
    if inspect.isclass(thing) or inspect.isfunction(thing):
        if not isinstance(thing, EnumMeta):  # its types are left to the docstring
            text = f"`{signature(word, thing, inside=True)}`"
            yield (
                text
                if len(text) <= LINE_WIDTH + 2
                else fill(text, LINE_WIDTH, subsequent_indent="  ")
            )
        yield markdown(docstring(thing))
    elif get_args(thing):
        *others, last = (f"`{kind.__name__}`" for kind in get_args(thing))
        yield f"{', '.join(others)} or {last}."
    if inspect.isclass(thing):
        members = members_of(thing)
        if len(members) > 16:  # of a class that are listed here; of more the reference tells
            (link,) = anchors_of([word])
            yield f"Its methods are in [the reference](reference.md{link})."
        elif members:
            yield "**Members**\n\n" + "\n".join(members)


def docstring(thing: Any) -> str:
    """Return a docstring, of a class with the arguments of the class that it extends."""
    own = inspect.getdoc(thing) or ""
    if not inspect.isclass(thing) or any(f"\n{head}" in own for head in ("Args:", "Attributes:")):
        return own
    for base in thing.__mro__[1:]:
        inherited = inspect.cleandoc(base.__doc__ or "")
        if base.__module__.startswith("kinolab") and "\nArgs:" in inherited:
            return f"{own}\n\nArgs:{inherited.partition(chr(10) + 'Args:')[2]}"
    return own
