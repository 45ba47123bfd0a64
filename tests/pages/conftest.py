"""One browser for all tests of a process."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.pages.browsing import CHROMIUM, FLAGS, OWN, WIDE, Opener


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        yield chromium
        chromium.close()


@pytest.fixture(scope="module")
def browse(browser: Any) -> Iterator[Opener]:
    """Open a page; in the end nothing was asked of a network, and nothing went wrong."""
    contexts, asked, said = [], [], []

    def guard(route: Any) -> None:
        if not route.request.url.startswith(OWN):
            asked.append(route.request.url)
            route.abort()
        else:
            route.continue_()

    def open_(path: Path, fragment: str = "", **options: Any) -> Any:
        context = browser.new_context(**{"viewport": WIDE, "reduced_motion": "reduce"} | options)
        contexts.append(context)
        page = context.new_page()
        page.route("**/*", guard)
        page.on("console", lambda message: said.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.goto(path.as_uri() + fragment)
        page.evaluate("async () => { await kinolab.ready; }")
        return page

    yield open_
    for context in contexts:
        context.close()
    assert asked == []
    assert said == []
