"""One self-contained file with a card per run; what all pages share is in it once."""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any, Literal

from kinolab.show.page.document import filled, library

MARK = "{{library}}"  # in the pages, where the library goes


@dataclass(frozen=True)
class Card:
    """A run in the gallery.

    Attributes:
        name: Where it lies, or what its author called it.
        title: Of the scenario; what went wrong where the run could not be read.
        verdict: Whether its files were checked and passed, failed, or could not be read.
        facts: Labels and values, in this order.
        poster: A picture of it, GIF or PNG; empty for none.
        page: Its interactive page; empty for none.
    """

    name: str
    title: str
    verdict: Literal["passed", "failed", "damaged"]
    facts: tuple[tuple[str, str], ...] = ()
    poster: bytes = b""
    page: str = ""


def gallery_html(title: str, cards: Sequence[Card]) -> str:
    """Return the page; it needs no network and asks for none.

    The interactive pages open in frames that may run scripts and nothing else.

    Args:
        title: Of the gallery.
        cards: In the order in which they are shown.
    """
    shared = library()
    runs = [_card(card, shared) for card in cards]
    return filled(
        _source("gallery.html"),
        {
            "title": html.escape(title),
            "style": _source("gallery.css"),
            "script": _source("gallery.js"),
            "runs": _as_json(runs),
            "shared": _as_json(shared),
        },
    )


def _card(card: Card, shared: str) -> dict[str, Any]:
    return {
        "name": card.name,
        "title": card.title,
        "verdict": card.verdict,
        "facts": [list(fact) for fact in card.facts],
        "poster": _data_address(card.poster),
        "page": card.page.replace(shared, MARK),
    }


def _data_address(picture: bytes) -> str:
    if not picture:
        return ""
    kind = "gif" if picture.startswith(b"GIF8") else "png"
    return f"data:image/{kind};base64,{base64.b64encode(picture).decode()}"


def _as_json(value: Any) -> str:
    """Write data so that nothing in it can end the script element that it stands in."""
    return json.dumps(value, ensure_ascii=False).replace("<", "\\u003c")


def _source(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")
