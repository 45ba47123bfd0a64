"""What somebody does with an input of the page, told from what a program does with it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from kinolab.studio.scene.session import Session

# What an input said when the work with it was done: while it says something newer, somebody is
# typing, and nothing that is older is shown in it.
_settled: dict[str, Any] = {}  # by the name that viser gives an input


def on_hand(session: Session, handle: Any, work: Callable[[Any], Any]) -> Any:
    """Have work done with an input's value when a person changes it; return the input."""
    _settled[handle._impl.uuid] = handle.value

    def heard(event: Any) -> None:
        if event.client is not None:  # a program's change has none
            value = event.target.value
            session.attempt(lambda: work(value))
            _settled[handle._impl.uuid] = value

    handle.on_update(heard)
    return handle


def on_press(session: Session, handle: Any, work: Callable[[], Any]) -> Any:
    """Have work done when a button is pressed; return the button."""
    handle.on_click(lambda _: session.attempt(work))
    return handle


def show(handle: Any, value: Any) -> None:
    """Show a value in an input, unless it is there already or somebody is typing."""
    now = handle.value
    if _same(now, value) or not _same(now, _settled.get(handle._impl.uuid, now)):
        return
    value = type(now)(value)
    _settled[handle._impl.uuid] = value
    handle.value = value


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(_same, a, b))
    # 1e-9: values that differ less are the same
    return abs(a - b) <= 1e-9 if isinstance(a, float) else bool(a == b)
