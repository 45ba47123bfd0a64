"""What the garbage collector does during a search."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def old_objects_left_alone() -> Iterator[None]:
    """Let the garbage collector look only at what is made inside.

    There are a million objects or so of imported modules and derived equations. A look at all of
    them takes a tenth of a second, in which nobody looks at the clock, and finds nothing.
    """
    mine = not gc.get_freeze_count()  # else somebody has done it already, and may undo it
    if mine:
        gc.freeze()
    try:
        yield
    finally:
        if mine:
            gc.unfreeze()
