"""One self-contained file of HTML: template, style, scripts and data put together."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from importlib.resources import files

from kinolab.render.page.bundle import bundle
from kinolab.render.page.content import Content
from kinolab.render.page.data import page_data

LIBRARY = "three.min.js"


def page_html(content: Content) -> str:
    """Return the page; it needs no network and asks for none."""
    data, pack = page_data(content)
    return filled(
        _source("page.html"),
        {
            "title": html.escape(content.title),
            "style": _source("page.css"),
            "library": library(),
            "script": _inside_script(bundle(_modules(), "main")),
            "data": json.dumps(data, allow_nan=False, ensure_ascii=False).replace("<", "\\u003c"),
            "pack": pack,
        },
    )


def library() -> str:
    """Return three.js as it stands in every page."""
    return _inside_script(_source(LIBRARY))


def _source(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _modules() -> dict[str, str]:
    return {
        entry.name.removesuffix(".js"): entry.read_text(encoding="utf-8")
        for entry in files(__package__).iterdir()
        if entry.name.endswith(".js") and entry.name != LIBRARY
    }


def filled(template: str, parts: Mapping[str, str]) -> str:
    """Put each part in the place of its {{name}}; what stands inside a part is left alone."""
    pieces = template.split("{{")
    filled = [pieces[0]]
    for piece in pieces[1:]:
        name, _, rest = piece.partition("}}")
        filled += [parts[name], rest]
    return "".join(filled)


def _inside_script(code: str) -> str:
    """Write what would end a script element in another way; in code it occurs in strings alone."""
    return code.replace("</script", "<\\/script")
