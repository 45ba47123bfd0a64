"""How long work is ended from inside: it looks at a stop now and then, and leaves by an exception.

What takes many small steps may end after any of them; only who asked for it knows what an
unfinished piece is worth, and catches the exception.
"""

from __future__ import annotations

from collections.abc import Callable
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
        StoppedError: If ``stop`` says to end.
    """
    if stop():
        raise CancelledError
