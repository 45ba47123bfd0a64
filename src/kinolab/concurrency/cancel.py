"""Cooperative cancellation: long work polls a token and raises when it is set.

Work may end after any of its steps; the caller catches the exception, and decides what a partial
result is worth.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from typing import TypeAlias

CancellationToken: TypeAlias = Callable[[], bool]


class CancelledError(Exception):
    """Work was cancelled; not a mistake, and never shown to users."""


def never_cancelled() -> bool:
    """The token that is never set."""
    return False


def raise_if_cancelled(stop: CancellationToken) -> None:
    """Poll a token.

    Raises:
        CancelledError: If ``stop`` is set.
    """
    if stop():
        raise CancelledError


def throttled(cancelled: CancellationToken, times: int) -> CancellationToken:
    """Return a token that polls another one only on every ``times``-th poll.

    For many small subproblems, each of which polls.
    """
    asked = count()
    known = False

    def cancelled_by_now() -> bool:
        nonlocal known
        if not known and next(asked) % times == 0:
            known = cancelled()
        return known

    return cancelled_by_now
