"""The text of a scenario while it is edited: every edit changes the bytes that it means to.

tomlkit keeps comments, order and spacing. What it writes is read again by Python's own reader and
compared with the same edit of plain values, so that no edit says more or less than was meant.
"""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import AoT, InlineTable, Whitespace

from kinolab.errors import InputError, Mistake
from kinolab.scenario.issues import KeyPath
from kinolab.scenario.load import toml_document
from kinolab.scenario.toml_text import value_text

FEWER = "Draw the obstacles as one mesh."


@dataclass(frozen=True)
class Put:
    """Write a value at a path; tables on the way are made."""

    path: KeyPath
    value: Any


@dataclass(frozen=True)
class Drop:
    """Remove what stands at a path, if it is there."""

    path: KeyPath


@dataclass(frozen=True)
class Add:
    """Add an entry to the list at a path."""

    path: KeyPath
    value: Mapping[str, Any]


Change = Put | Drop | Add


@dataclass
class ScenarioText:
    """A scenario's text with its history.

    Attributes:
        text: What the file would say now.
        saved: What the file says.
    """

    text: str
    saved: str = ""
    _past: list[tuple[str, str]] = field(default_factory=list)  # what was done, the text before
    _future: list[tuple[str, str]] = field(default_factory=list)

    @property
    def values(self) -> dict[str, Any]:
        """What the text says, as plain values.

        Raises:
            InputError: If it is not TOML.
        """
        return toml_document(self.text, "the scenario", FEWER)

    @property
    def last(self) -> str:
        """What would be undone, in words; empty where there is nothing."""
        return self._past[-1][0] if self._past else ""

    @property
    def next(self) -> str:
        """What would be done again, in words; empty where there is nothing."""
        return self._future[-1][0] if self._future else ""

    def edit(self, what: str, changes: Sequence[Change], *, going_on: bool = False) -> bool:
        """Change the text; say whether it is another one now.

        Args:
            what: The edit in words, for undo.
            changes: Applied in order.
            going_on: Whether it belongs to the last edit if that has the same words, as the many
                steps of one drag do.

        Raises:
            InputError: If the text cannot be changed so; it stays as it was.
        """
        return self.write(what, edited(self.text, changes), going_on=going_on)

    def write(self, what: str, text: str, *, going_on: bool = False) -> bool:
        """Replace the text as a whole; say whether it is another one now."""
        if text == self.text:
            return False
        if not (going_on and self.last == what):
            self._past.append((what, self.text))
            del self._past[:-2000]  # edits that can be undone; each is a text of some kilobytes
        self._future.clear()
        self.text = text
        return True

    def undo(self) -> str:
        """Take the last edit back; return it in words, nothing where there is none."""
        return self._step(self._past, self._future)

    def redo(self) -> str:
        """Do again what was undone last; return it in words, nothing where there is none."""
        return self._step(self._future, self._past)

    def _step(self, left: list[tuple[str, str]], right: list[tuple[str, str]]) -> str:
        if not left:
            return ""
        what, text = left.pop()
        right.append((what, self.text))
        self.text = text
        return what


def edited(text: str, changes: Sequence[Change]) -> str:
    """Return a TOML text with changes, all else byte for byte as it was.

    Raises:
        InputError: If the text is not TOML, or cannot be changed so.
    """
    wanted = toml_document(text, "the scenario", FEWER)
    plain = text.replace("\r\n", "\n")
    try:
        document = tomlkit.parse(plain)
        for change in changes:
            _apply(document, change, _Written)
            _apply(wanted, change, _Plain)
        plain = document.as_string()
        if tomllib.loads(plain) == wanted:
            return plain.replace("\n", "\r\n") if "\r\n" in text else plain
    except (TOMLKitError, KeyError, IndexError, TypeError, ValueError, AttributeError):
        pass
    what = "this cannot be changed where it is written."
    raise InputError([Mistake("the scenario", what, "Change it in the text, under File.")])


class _Plain:
    """Plain values."""

    @staticmethod
    def section() -> Any:
        return {}

    @staticmethod
    def put(holder: Any, key: str | int, value: Any) -> None:
        holder[key] = copy.deepcopy(value)

    @staticmethod
    def add(holder: Any, key: str | int, entry: Mapping[str, Any]) -> None:
        holder.setdefault(key, []).append(dict(entry))


class _Written(_Plain):
    """The same as tomlkit writes them."""

    @staticmethod
    def section() -> Any:
        return tomlkit.table()

    @staticmethod
    def put(holder: Any, key: str | int, value: Any) -> None:
        inline = isinstance(holder, InlineTable)
        holder[key] = tomlkit.parse(f"v = {value_text(value)}" + "\n" * (not inline))["v"]
        if inline and not holder.as_string().endswith(" }"):  # as it stood before
            holder.value.add(Whitespace(" "))

    @staticmethod
    def add(holder: Any, key: str | int, entry: Mapping[str, Any]) -> None:
        there = holder.get(key)
        if there is not None and not isinstance(there, AoT):  # a list of { … }
            there.append(tomlkit.parse(f"v = {value_text(entry)}")["v"])
            return
        before = holder.as_string() if there is None else there.as_string()
        table = tomlkit.parse("".join(f"{k} = {value_text(v)}\n" for k, v in entry.items()))
        made = tomlkit.table()
        for name, item in table.items():
            made.add(name, item)
        if before.endswith("\n\n"):  # a blank line belongs to the table above it
            made.add(tomlkit.nl())
        elif before:
            made.trivia.indent = "\n"
        if there is None:
            holder[key] = there = tomlkit.aot()
        there.append(made)


def _apply(document: Any, change: Change, kind: type[_Plain]) -> None:
    holder = document
    *way, last = change.path
    for key in way:
        if isinstance(holder, dict) and key not in holder:
            if isinstance(change, Drop):
                return
            holder[key] = kind.section()
        holder = holder[key]
    if isinstance(change, Put):
        kind.put(holder, last, change.value)
    elif isinstance(change, Add):
        kind.add(holder, last, change.value)
    elif not isinstance(holder, dict) or last in holder:
        del holder[last]
