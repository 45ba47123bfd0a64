"""Assemble a self-contained HTML file from template, style, scripts and data."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from importlib.resources import files

from kinolab.show.page.bundle import bundle
from kinolab.show.page.content import Content, Driving
from kinolab.show.page.data import page_data

LIBRARY = "three.min.js"
FOLDERS = ("", "drive")  # of modules; their names are unique
STYLES = ("page.css", "drive/drive.css")


def page_html(content: Content) -> str:
    """Return the page; it makes no network requests, a live one only to its own server."""
    data, pack = page_data(content)
    return filled(
        _source("page.html"),
        {
            "title": html.escape(content.title),
            "connect": "'self'" if content.live else "'none'",
            "style": "\n".join(_source(name) for name in STYLES),
            "library": library(),
            "script": _inside_script(bundle(_modules(content.driving), "main")),
            "data": json.dumps(data, allow_nan=False, ensure_ascii=False).replace("<", "\\u003c"),
            "pack": pack,
        },
    )


def library() -> str:
    """Return three.js as embedded in every page."""
    return _inside_script(_source(LIBRARY))


def _source(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _modules(driving: Driving | None = None) -> dict[str, str]:
    """Return the sources of all modules by name, including the machine to be driven."""
    machine = "null" if driving is None else driving.code
    return {"driven_machine": f"export const driven_machine = {machine};"} | {
        entry.name.removesuffix(".js"): entry.read_text(encoding="utf-8")
        for folder in FOLDERS
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
    """Escape what would end a script element; in code it occurs in strings only."""
    return code.replace("</script", "<\\/script")
