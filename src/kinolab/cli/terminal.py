"""Text for a terminal: what comes from files may not steer it, nor pass for a line of ours."""

from __future__ import annotations

import json
from typing import Any

import click

from kinolab.errors import UNPRINTED


def escaped(text: str) -> str:
    """Return a text as one line that is only seen, such as ``\\x1b`` for an escape character."""
    return UNPRINTED.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


def say(text: str, *, err: bool = False) -> None:
    """Print lines of text on stdout, or on stderr, escaped."""
    click.echo("\n".join(escaped(line) for line in text.split("\n")), err=err)


def echo_json(data: Any) -> None:
    """Print plain data as JSON on one line; what a terminal would obey is escaped as JSON does."""
    text = json.dumps(data, ensure_ascii=False)
    click.echo(UNPRINTED.sub(lambda found: f"\\u{ord(found[0]):04x}", text))
