"""Who watches a search in a browser, if anybody does: ``plan SCENARIO --live``."""

from __future__ import annotations

import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from kinolab.cli.progress import Progress

if TYPE_CHECKING:
    from kinolab.problem import Problem
    from kinolab.search import Budget
    from kinolab.show.view.live_page import LivePage
    from kinolab.solve import Plan


class Spectators:
    """Nobody, or who has a live page open.

    Args:
        page: None where nobody watches.
        expected: Whether a browser was started that may not be there yet.
    """

    def __init__(self, page: LivePage | None = None, *, expected: bool = False) -> None:
        self._page, self._expected = page, expected

    def watch(self, budget: Budget) -> None:
        """Have them see what a search explores."""
        if self._page:
            budget.viewer = self._page.explored

    def found(self, plan: Plan) -> None:
        """Show them a motion."""
        if self._page and plan.trajectory is not None:
            self._page.found(plan.trajectory)

    def leave(self, finished: Path) -> None:
        """Give them the finished page, where there is one, and wait until they have it."""
        if self._page:
            page = finished.read_bytes() if finished.is_file() else None
            self._page.end(page, expected=self._expected)


@contextmanager
def spectators(
    problem: Problem, progress: Progress, *, live: bool, browser: bool
) -> Iterator[Spectators]:
    """Serve a live page inside, where one is wanted, and open it in a browser."""
    if not live:
        yield Spectators()
        return
    from kinolab.show.view.live_page import LivePage

    page = LivePage(problem, f"{problem.name}: a plan is being searched.")
    with page.served(), progress.heard(page.say):
        progress(f"live on {page.address}", lasting=True)
        yield Spectators(page, expected=browser and webbrowser.open(page.address))
