"""Keys and values as TOML 1.0 text."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from kinolab.untrusted import ELEMENTS

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_MUST_ESCAPE = re.compile(r'[\x00-\x1f\x7f"\\\ud800-\udfff]')
_SHORT = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t", "\r": "\\r"}

_PART = r"""(?>[A-Za-z0-9_-]++|"[^"\n]*+"|'[^'\n]*+')"""
_MORE = rf"(?>[ \t]*+\.[ \t]*+{_PART})"
_LONG = rf"(?P<long>(?<![A-Za-z0-9_-]){_PART}{_MORE}{{{ELEMENTS['parts of a key']}}})"
# What is no key: texts of several lines, texts of one line, comments.
_TEXTS = (
    r'"""(?s:.*?)"""',
    r"'''(?s:.*?)'''",
    r'"(?>[^"\\\n]|\\.)*+"',
    r"'[^'\n]*+'",
    r"#[^\n]*+",
)
_TOKEN = re.compile("|".join((*_TEXTS[:2], _LONG, *_TEXTS[2:])))


def key_text(key: str) -> str:
    """Write a key, quoted where TOML asks for it."""
    return key if _BARE_KEY.fullmatch(key) else string_text(key)


def string_text(text: str) -> str:
    """Write a basic string; everything that cannot stand in one is escaped."""
    escaped = _MUST_ESCAPE.sub(lambda c: _SHORT.get(c[0], f"\\u{ord(c[0]):04x}"), text)
    return f'"{escaped}"'


def value_text(value: object) -> str:
    """Write any value that TOML has; floats keep every digit, tables become inline tables."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return string_text(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(value_text, value))}]"
    if isinstance(value, Mapping):
        entries = ", ".join(f"{key_text(key)} = {value_text(item)}" for key, item in value.items())
        return f"{{ {entries} }}" if entries else "{}"
    return repr(value) if isinstance(value, int | float) else str(value)


def shown(value: object) -> str:
    """Write a value for a message: on one line, and shortened where it is long."""
    try:
        return shortened(value_text(value))
    except (RecursionError, ValueError):  # endless nesting, or an integer of over 4300 digits
        return "this value"


def shortened(text: str, limit: int = 60) -> str:
    """Cut a text that would drown the message that quotes it."""
    return text if len(text) <= limit else f"{text[:limit]}…"


def values_in(document: object) -> int:
    """Return how many values lists and tables hold together, at least where they are too many.

    To tell what is wrong with so many takes longer than to read them.
    """
    count, left = 0, [document]
    while left and count <= ELEMENTS["values"]:
        value = left.pop()
        inside = value.values() if isinstance(value, dict) else value
        if isinstance(inside, str) or not isinstance(inside, Iterable):
            continue
        held = list(inside)
        count += len(held)
        left += held
    return count


def long_key(text: str) -> int | None:
    """Return the line, counted from 1, of the first key of too many parts.

    It is found before TOML is read: what tomllib keeps of one grows with the square of its parts,
    8 GB for a file of 1 MB.
    """
    for token in _TOKEN.finditer(text):
        if token["long"] is not None:
            return text.count("\n", 0, token.start()) + 1
    return None
