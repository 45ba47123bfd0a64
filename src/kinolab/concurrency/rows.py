"""Compiled loops over rows, on all processors at once.

The loops release the GIL, so threads are enough. What a row gives must not depend on the others:
then it is the same, bit for bit, with one processor as with many.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

from kinolab.concurrency.processors import processors
from kinolab.concurrency.submitting import submitted

T = TypeVar("T")

MOST = 8  # parts
# [s] of work that pays for a thread: until it has the GIL and the caller has it back, 0.1 to 0.4 ms
# pass (measured with CPython 3.11 on two processors).
WORTH = 1e-3


def in_parts(work: Callable[[slice], T], rows: int, seconds: float) -> list[T]:
    """Return what a function makes of consecutive ranges of rows, in their order.

    Args:
        work: Works on a range of rows, mostly in compiled code.
        seconds: What all of them take in one thread, about.
    """
    parts = max(1, min(processors(), MOST, rows, int(seconds / WORTH)))
    ends = [rows * k // parts for k in range(parts + 1)]
    first, *others = (slice(*pair) for pair in itertools.pairwise(ends))
    begun = [submitted(_threads(), work, part) for part in others]
    return [work(first), *(part.result() for part in begun)]


@cache
def _threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(MOST, thread_name_prefix="rows")


if hasattr(os, "register_at_fork"):  # a child has none of its parent's threads
    os.register_at_fork(after_in_child=_threads.cache_clear)
