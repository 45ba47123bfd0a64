"""Pages in the browser that all tests of a process share."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.show.view.browsing import OWN, WIDE, Opener


@pytest.fixture(scope="module")
def browse(browser: Any) -> Iterator[Opener]:
    """Open a file or an address; in the end nobody else was asked, and nothing went wrong."""
    contexts, asked, said = [], [], []
    own: list[str] = []  # addresses of servers that are ours

    def guard(route: Any) -> None:
        if not route.request.url.startswith((*OWN, *own)):
            asked.append(route.request.url)
            route.abort()
        else:
            route.continue_()

    def open_(place: Path | str, fragment: str = "", **options: Any) -> Any:
        if isinstance(place, str):
            own.append(place)
        context = browser.new_context(**{"viewport": WIDE, "reduced_motion": "reduce"} | options)
        contexts.append(context)
        page = context.new_page()
        page.route("**/*", guard)
        page.on("console", lambda message: said.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.goto((place if isinstance(place, str) else place.as_uri()) + fragment)
        page.evaluate("async () => { await window.kinolab?.ready; }")
        return page

    yield open_
    for context in contexts:
        context.close()
    assert asked == []
    assert said == []
