"""The live page of a search in a browser: ``plan SCENARIO --live``."""

from __future__ import annotations

import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from kinolab.cli.progress import Progress

if TYPE_CHECKING:
    from kinolab.problem import PlanningTask
    from kinolab.show.view.live_page import LivePage


@contextmanager
def live_page(
    problem: PlanningTask, progress: Progress, *, live: bool, browser: bool
) -> Iterator[tuple[LivePage | None, bool]]:
    """Serve a live page inside if wanted; yield it, and whether a browser was opened on it.

    Args:
        live: Whether it is wanted.
        browser: Whether to open it in one.
    """
    if not live:
        yield None, False
        return
    from kinolab.show.view.live_page import LivePage

    page = LivePage(problem, f"Searching for a plan: {problem.name}")
    with page.served(), progress.heard(page.say):
        progress(f"live on {page.address}", lasting=True)
        yield page, browser and webbrowser.open(page.address)
