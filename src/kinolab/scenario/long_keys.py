"""Keys of very many parts, a.a.a.a and so on, found before TOML is read.

What tomllib keeps of one grows with the square of its parts: 8 GB for a file of 1 MB.
"""

from __future__ import annotations

import re

MOST_PARTS = 32

_PART = r"""(?>[A-Za-z0-9_-]++|"[^"\n]*+"|'[^'\n]*+')"""
_MORE = rf"(?>[ \t]*+\.[ \t]*+{_PART})"
_LONG = rf"(?P<long>(?<![A-Za-z0-9_-]){_PART}{_MORE}{{{MOST_PARTS}}})"
# What is no key: texts of several lines, texts of one line, comments.
_TEXTS = (
    r'"""(?s:.*?)"""',
    r"'''(?s:.*?)'''",
    r'"(?>[^"\\\n]|\\.)*+"',
    r"'[^'\n]*+'",
    r"#[^\n]*+",
)
_TOKEN = re.compile("|".join((*_TEXTS[:2], _LONG, *_TEXTS[2:])))


def long_key(text: str) -> int | None:
    """Return the line, counted from 1, of the first key of more than ``MOST_PARTS``."""
    for token in _TOKEN.finditer(text):
        if token["long"] is not None:
            return text.count("\n", 0, token.start()) + 1
    return None
