"""Assemble a self-contained HTML file from template, style, scripts and data."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from kinolab.show.page.bundle import bundle
from kinolab.show.page.data import page_data
from kinolab.show.scene.content import Content, Driving

LIBRARY = "three.min.js"
POLICY = re.compile(r'<meta http-equiv="Content-Security-Policy" content="([^"]*)">')
HASH = re.compile(r"'sha256-[A-Za-z0-9+/]{43}='")


def page_html(content: Content) -> str:
    """Return the page; it makes no network requests, a live one only to its own server.

    Its content security policy names its own scripts and styles by their hashes, so that a browser
    runs nothing else, whatever a text on the page contains.
    """
    data, pack = page_data(content)
    style = "\n".join(_source(name) for name in ("page.css", "drive/drive.css"))
    script = _inside_script(bundle(_modules(content.driving), "main"))
    return filled(
        _source("page.html"),
        {
            "title": html.escape(content.title),
            "scripts": f"{source_hash(library())} {source_hash(script)}",
            "styles": source_hash(style),
            "connect": "'self'" if content.live else "'none'",
            "style": style,
            "library": library(),
            "script": script,
            "data": as_json(data),
            "pack": pack,
        },
    )


def source_hash(source: str) -> str:
    """Return how a content security policy names a script or style element's text.

    Source: W3C, Content Security Policy Level 3, section 2.3.1.
    """
    return f"'sha256-{base64.b64encode(hashlib.sha256(source.encode()).digest()).decode()}'"


def allowed_by(page: str, directive: str) -> list[str]:
    """Return the hashes that the policy of a page allows, such as in ``script-src``."""
    policy = POLICY.search(page)
    found = re.search(rf"{directive} ([^;]*)", policy[1]) if policy else None
    return HASH.findall(found[1]) if found else []


@cache
def library() -> str:
    """Return three.js as embedded in every page."""
    return _inside_script(_source(LIBRARY))


def as_json(data: Any) -> str:
    """Return data as JSON that cannot end its script element."""
    return json.dumps(data, allow_nan=False, ensure_ascii=False).replace("<", "\\u003c")


def _source(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _modules(driving: Driving | None = None) -> dict[str, str]:
    """Return the sources of all modules by name, including the machine to be driven."""
    machine = "null" if driving is None else driving.code
    return {"driven_machine": f"export const driven_machine = {machine};"} | {
        entry.name.removesuffix(".js"): entry.read_text(encoding="utf-8")
        for folder in ("", "drive")  # of modules; their names are unique
        for entry in files(__package__).joinpath(folder).iterdir()
        if entry.name.endswith(".js") and entry.name != LIBRARY
    }


def filled(template: str, parts: Mapping[str, str]) -> str:
    """Replace each {{name}} by its part, without expanding the parts themselves."""
    pieces = template.split("{{")
    filled = [pieces[0]]
    for piece in pieces[1:]:
        name, _, rest = piece.partition("}}")
        filled += [parts[name], rest]
    return "".join(filled)


def _inside_script(code: str) -> str:
    """Escape what would end a script element, or keep it open; in code it is in strings only.

    Source: HTML Living Standard, 4.12.1.3 Restrictions for contents of script elements.
    """
    return re.sub(r"<(?=/script|!--)", r"<\\", code, flags=re.IGNORECASE)
