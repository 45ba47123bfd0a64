"""How long work is ended from inside: it asks a token now and then, and leaves by an exception.

What takes many small steps may end after any of them; only who asked for it knows what an
unfinished piece is worth, and catches the exception.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from typing import TypeAlias

CancellationToken: TypeAlias = Callable[[], bool]


class CancelledError(Exception):
    """Work was ended before it was done; no mistake, and nothing for a user to read."""


def never_cancelled() -> bool:
    """Say that work may go on."""
    return False


def raise_if_cancelled(stop: CancellationToken) -> None:
    """Look whether to go on.

    Raises:
        CancelledError: If ``stop`` says to end.
    """
    if stop():
        raise CancelledError


def throttled(cancelled: CancellationToken, times: int) -> CancellationToken:
    """Return a token that asks another one only every so many times it is asked itself.

    So that many small subproblems count as a large one.
    """
    asked = count()
    known = False

    def cancelled_by_now() -> bool:
        nonlocal known
        if not known and next(asked) % times == 0:
            known = cancelled()
        return known

    return cancelled_by_now
