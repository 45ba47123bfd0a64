"""What somebody does with an input of the page, told from what a program does with it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from kinolab.studio.session import Session

APART = 1e-9  # values that differ less are the same


def on_hand(session: Session, handle: Any, work: Callable[[Any], Any]) -> Any:
    """Have work done with an input's value when a person changes it; return the input."""

    def heard(event: Any) -> None:
        if event.client is not None:  # a program's change has none
            session.attempt(lambda: work(event.target.value))

    handle.on_update(heard)
    return handle


def on_press(session: Session, handle: Any, work: Callable[[], Any]) -> Any:
    """Have work done when a button is pressed; return the button."""
    handle.on_click(lambda _: session.attempt(work))
    return handle


def show(handle: Any, value: Any) -> None:
    """Show a value in an input, unless it is there already."""
    now = handle.value
    if isinstance(value, float | int) and not isinstance(value, bool):
        if abs(now - value) > APART:
            handle.value = type(now)(value)
    elif isinstance(value, tuple) and value and isinstance(value[0], float):
        if max(abs(a - b) for a, b in zip(now, value, strict=True)) > APART:
            handle.value = value
    elif now != value:
        handle.value = value
