"""Long computations say what they do to whoever listens, and to nobody else."""

from __future__ import annotations

import io
import sys

import click
import pytest

from kinolab.cli.progress import Progress
from kinolab.concurrency.stages import doing, heard_by


def test_what_is_done_is_heard_inside_and_by_the_nearest_listener() -> None:
    outer, inner = list[str](), list[str]()
    doing("before")
    with heard_by(outer.append):
        doing("first")
        with heard_by(inner.append):
            doing("second")
        doing("third")
    doing("after")
    assert (outer, inner) == (["first", "third"], ["second"])


def test_whoever_listens_may_end_it() -> None:
    """As Ctrl-C does by way of a command's progress."""
    heard = list[str]()
    with pytest.raises(KeyboardInterrupt), heard_by(_interrupted):
        doing("this")
    with heard_by(heard.append):
        doing("that")
    assert heard == ["that"]


def _interrupted(_: str) -> None:
    raise KeyboardInterrupt


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(("quiet", "shown"), [(False, True), (True, False)])
def test_a_command_shows_it_on_a_terminal_until_it_ends(
    quiet: bool, shown: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    with click.Context(click.Command("plan")):
        Progress(quiet)
        doing("dividing it into convex parts")
    doing("something else")
    assert ("dividing it into convex parts" in terminal.getvalue()) is shown
    assert "something else" not in terminal.getvalue()
