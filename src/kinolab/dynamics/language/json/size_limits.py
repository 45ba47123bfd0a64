"""Size limits of machine files, checked before anything is built from them.

Expressions are differentiated several times: 50 000 terms, or powers of powers of powers, take
minutes and gigabytes. No machine of a course reaches a tenth of the limits.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from kinolab.errors import Mistake, is_broken
from kinolab.untrusted import ELEMENTS

MAX_ENTRIES: Mapping[str, int] = {"bodies": 200, "coordinates": 64}


def written_out(tree: Any, sizes: Mapping[str, int]) -> int:
    """Return the number of terms of an expression tree in which some names stand for many."""
    if isinstance(tree, list):
        return 1 + sum(written_out(entry, sizes) for entry in tree[1:])
    return sizes.get(tree, 1) if isinstance(tree, str) else 1


def size_mistakes(data: Any) -> Iterator[Mistake]:
    """Yield mistakes where plain data exceed the limits or a text is invalid.

    Args:
        data: Parsed JSON.
    """
    for name, most in MAX_ENTRIES.items():
        entries = data.get(name) if isinstance(data, dict) else None
        if isinstance(entries, list) and len(entries) > most:
            what = f"these are {len(entries)} {name}, and a machine may have {most}."
            yield Mistake(name, what, "Take fewer.")
    broken = [text for text in _within(data) if isinstance(text, str) and is_broken(text)]
    for text in dict.fromkeys(broken):
        yield Mistake(f"{text!a}", "this is no Unicode text.", "Write it in UTF-8.")
    # In all expressions, records and lists; a corner of a path is two numbers. To read and to
    # compile one takes 2 ms, wherever it is from.
    if sum(1 for _ in _within(data)) + 2 * _corners(data) > 20_000:
        what = "it holds more than 20000 values."
        yield Mistake("", what, "Take fewer bodies and shorter expressions.")
    # In all expressions: of a maximum, each term is compared with each, and forces have kinks. What
    # time alone moves has no part in forces, and of its path's corners nothing is compared.
    maxima = sum(isinstance(value, list) and value[:1] == ["max"] for value in _within(data))
    maxima += _corners(data) - _corners(_prescribed(data))
    if maxima > 50:
        yield Mistake("", f"it holds {maxima} maxima; 50 are the most.", "Take fewer.")
    for value in _within(data):
        if isinstance(value, dict) and "expression" in value:
            yield from _expression_mistakes(value["expression"])


def _prescribed(data: Any) -> list[Any]:
    """Return the frames of massless bodies that time alone moves."""
    return [
        body.get("frame")
        for body in (_list(data, "bodies") if isinstance(data, dict) else ())
        if isinstance(body, dict)
        and body.get("prescribed") is True
        and not body.get("added_mass")
        and all(entry == {"expression": 0} for entry in (body.get("mass"), *_list(body, "inertia")))
    ]


def _list(entry: Mapping[str, Any], key: str) -> list[Any]:
    found = entry.get(key)
    return found if isinstance(found, list) else []


def _corners(data: Any) -> int:
    """Return the number of corners of packed paths, 16 bytes each, of which base64 makes 64/3."""
    return sum(
        len(value[2]) * 3 // 64
        for value in _within(data)
        if isinstance(value, list)
        and value[:1] == ["hinges"]
        and isinstance(value[-1], str)
        and len(value) == 3
    )


def _expression_mistakes(tree: Any) -> Iterator[Mistake]:
    shown = f"expression {str(tree)[:40]!r}…"
    count = sum(1 for _ in _within(tree))
    if count > ELEMENTS["terms"]:
        what = f"it has {count} names, numbers and operations; {ELEMENTS['terms']} are the most."
        yield Mistake(shown, what, "Shorten it.")
    elif _nested(tree, "pow") > 4:  # nesting depth of powers
        what = "more than 4 powers are nested in it."
        yield Mistake(shown, what, "Write powers of powers as one power.")
    elif _nested(tree) > 60:  # nesting depth of operations
        what = "it is nested too deeply, more than 60 operations within one another."
        yield Mistake(shown, what, "Write sums and products in one list.")


def _within(data: Any) -> Iterator[Any]:
    """Yield a value and everything nested in it, keys included."""
    left = [data]
    while left:
        value = left.pop()
        yield value
        if isinstance(value, dict):
            left += [*value, *value.values()]
        elif isinstance(value, list):
            left += value


def _nested(tree: Any, name: str = "") -> int:
    """Return the nesting depth of operations, or of those of one name."""
    most, left = 0, [(tree, 0)]
    while left:
        value, around = left.pop()
        if isinstance(value, list):
            around += not name or value[:1] == [name]
            most = max(most, around)
            left += [(entry, around) for entry in value]
    return most
