"""A self-contained gallery file with a card per run; shared code is embedded once."""

from __future__ import annotations

import base64
import html
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any, Literal

from kinolab.show.page.document import allowed_by, as_json, filled, library, source_hash


@dataclass(frozen=True)
class Card:
    """A run in the gallery.

    Attributes:
        name: Its folder, or a name given by its author.
        title: Title of the scenario; the error if the run could not be read.
        verdict: Whether verification of its files passed, failed, or they could not be read.
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
    """Return the page, which makes no network requests.

    The interactive pages open in frames that may run their own scripts and nothing else: a frame
    keeps the policy of the page around it, so this one's lists the scripts of all of them.

    Args:
        cards: In display order.
    """
    shared, style, script = library(), _source("gallery.css"), _source("gallery.js")
    runs = [_card(card, shared) for card in cards]
    return filled(
        _source("gallery.html"),
        {
            "title": html.escape(title),
            "scripts": _allowed(script, "script-src", cards),
            "styles": _allowed(style, "style-src", cards),
            "style": style,
            "script": script,
            "runs": as_json(runs),
            "shared": as_json(shared),
        },
    )


def _allowed(own: str, directive: str, cards: Sequence[Card]) -> str:
    """Return the hashes of the gallery's own script or style, and of those of all pages in it."""
    inside = (allowed for card in cards for allowed in allowed_by(card.page, directive))
    return " ".join(dict.fromkeys([source_hash(own), *inside]))


def _card(card: Card, shared: str) -> dict[str, Any]:
    return {
        "name": card.name,
        "title": card.title,
        "verdict": card.verdict,
        "facts": [list(fact) for fact in card.facts],
        "poster": _data_address(card.poster),
        # "<library>" stands for it in the pages, where no text has an unescaped <
        "page": card.page.replace(shared, "<library>"),
    }


def _data_address(picture: bytes) -> str:
    if not picture:
        return ""
    kind = "gif" if picture.startswith(b"GIF8") else "png"
    return f"data:image/{kind};base64,{base64.b64encode(picture).decode()}"


def _source(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")
