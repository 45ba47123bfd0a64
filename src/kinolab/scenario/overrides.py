"""``--set KEY=VALUE``: one more key of the scenario, or another value for one that is there."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

from kinolab.errors import Mistake, is_broken, listed
from kinolab.scenario.angles import angle_of
from kinolab.scenario.issues import KeyPath, Override
from kinolab.scenario.toml_text import long_key, shortened, shown

_MOST_EQUALS = 100  # signs in a quoted key
_SHOWN = 200  # characters of an override that a message quotes
_SHAPE = "Write KEY=VALUE, for example planner.time_limit=5."


class _RefusedError(Exception):
    """An override that cannot be carried out; the arguments are what and remedy."""


def apply_overrides(
    document: dict[str, Any], texts: Sequence[str]
) -> tuple[tuple[Override, ...], list[Mistake]]:
    """Change ``document`` as the overrides say, in their order; tell those that could not be."""
    done, mistakes = [], []
    for text in texts:
        try:
            done.append(Override(shortened(text, _SHOWN), *_apply(document, text)))
        except _RefusedError as refused:
            mistakes.append(Mistake(override_place(text), *refused.args))
    return tuple(done), mistakes


def apply_changes(
    document: dict[str, Any], changes: Mapping[str, object], by: str
) -> tuple[tuple[Override, ...], list[Mistake]]:
    """Change ``document`` by values from Python, by dotted key; tell those that could not be.

    Args:
        document: Keys and values as TOML would have them.
        changes: Values by dotted key, as TOML would have them.
        by: What was called, for messages.
    """
    done, mistakes = [], []
    for key, value in changes.items():
        try:
            keys = _keys(key)
            if keys is None:
                raise _RefusedError("it is not a dotted key.", "Write it as start.x.")
            done.append(Override(shortened(key, _SHOWN), *_put(document, keys, value), by))
        except _RefusedError as refused:
            mistakes.append(Mistake(f"{by} {shortened(key, _SHOWN)}", *refused.args))
    return tuple(done), mistakes


def override_place(text: str) -> str:
    """Return how mistakes name an override."""
    return f"--set {shortened(ascii(text)[1:-1] if is_broken(text) else text, _SHOWN)}"


def _apply(document: dict[str, Any], text: str) -> tuple[KeyPath, object]:
    if is_broken(text):
        raise _RefusedError("the text is not Unicode.", "Write it in UTF-8.")
    if len(text) > 100_000:
        raise _RefusedError("it has more than 100000 characters.", "Write it into the file.")
    keys, value = _split(text)
    return _put(document, keys, _parsed(value))


def _split(text: str) -> tuple[list[str], str]:
    """Cut at the first "=" that is not inside a quoted key."""
    head, equals, tail = text.partition("=")
    if not equals:
        raise _RefusedError("there is no '=' in it.", _SHAPE)
    for _ in range(_MOST_EQUALS):
        if (keys := _keys(head)) is not None:
            return keys, tail
        more, equals, tail = tail.partition("=")
        if not equals:
            break
        head = f"{head}={more}"
    raise _RefusedError("what stands before '=' is not a dotted key.", _SHAPE)


def _keys(text: str) -> list[str] | None:
    """Read a dotted TOML key; None if it is not one."""
    table = _toml(f"{text} = 0") if "\n" not in text and "\r" not in text else None
    keys: list[str] = []
    while isinstance(table, dict):
        if not table:  # the rest was a comment
            return None
        key, table = next(iter(table.items()))
        keys.append(key)
    return keys or None


def _parsed(text: str) -> Any:
    """Read a TOML value; a word that is none is text."""
    text = text.strip()
    table = _toml(f"value = {text}")
    if table is not None and list(table) == ["value"]:
        return table["value"]
    if not text:
        raise _RefusedError("nothing follows '='.", _SHAPE)
    if (entries := _with_angles(text)) is not None:
        return entries
    if text[0] in "\"'[{":
        raise _RefusedError(
            f"{shortened(text)} is not a TOML value.", "Close every quote, bracket and brace."
        )
    return text


def _with_angles(text: str) -> list[Any] | None:
    """Read a list such as [-pi, pi/2], whose angles TOML wants in quotes; None if it is none."""
    if not (text.startswith("[") and text.endswith("]")):
        return None
    parts = [part.strip() for part in text[1:-1].split(",")]
    if not all(angle_of(part) is not None or _toml(f"value = {part}") for part in parts):
        return None
    return [part if angle_of(part) is not None else _parsed(part) for part in parts]


def _toml(text: str) -> dict[str, Any] | None:
    if long_key(text):
        return None
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError):  # not TOML, or a number of over 4300 digits
        return None


def _put(document: dict[str, Any], keys: Sequence[str], value: Any) -> tuple[KeyPath, object]:
    """Write ``value`` at ``keys``; tables on the way are made, entries of lists must exist.

    Returns:
        The path, and what stood there; None where nothing did.
    """
    holder: Any = document
    path: list[str | int] = []
    before: object = None
    for last, key in enumerate(keys, start=1 - len(keys)):
        step = _step(holder, key, path)
        path.append(step)
        if last == 0:
            before = holder.get(step) if isinstance(holder, dict) else holder[int(step)]
            holder[step] = value
        elif isinstance(holder, list):
            holder = holder[int(step)]
        elif (  # a number counts entries, but in ``[start]`` and the like, where it is a name
            step not in holder
            and keys[len(path)].isdigit()
            and (len(path) > 1 or path[0] == "keep_out")
        ):
            holder = []  # has no entries, which the next step tells
        else:
            holder = holder.setdefault(step, {})
    return tuple(path), before


def _step(holder: object, key: str, path: Sequence[str | int]) -> str | int:
    """The index that ``key`` means in ``holder``: of a list, a number or the name of an entry."""
    if isinstance(holder, dict):
        return key
    name = ".".join(str(part) if isinstance(part, str) else str(part + 1) for part in path)
    if not isinstance(holder, list):
        raise _RefusedError(
            f"{name} is {shown(holder)} and has no keys.", "Give a new value to it as a whole."
        )
    called = [entry.get("name") if isinstance(entry, dict) else None for entry in holder]
    if key in called and not key.isdigit():
        return called.index(key)
    if not (key.isascii() and key.isdigit() and len(key) < 10 and 1 <= int(key) <= len(holder)):
        names = [one for one in called if isinstance(one, str)]
        raise _RefusedError(
            f"{name} has no entry {shortened(key)}; it has {len(holder)}.",
            f"Entries count from 1{f', or are called {listed(names)}' if names else ''}.",
        )
    return int(key) - 1
