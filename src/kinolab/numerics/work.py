"""A clock of work instead of time: the same seed gets as far on a busy computer as on an idle one.

Long computations charge what they take on an idle computer, by rules that were fitted to the
scenarios that come with kinolab and to dynobench, and then adjusted by hand (one core of an AMD
EPYC). They hold within a factor of two for most of them, and charge too little for large meshes and
large machines; that matters little: a budget need not be exact, but the same every time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

TICK_BITS = 40  # work is counted in multiples of 2^-40 s


@dataclass
class WorkClock:
    """Work done so far.

    Attributes:
        seconds: What it takes on an idle computer, about, in [s].
    """

    seconds: float = 0.0


_running: ContextVar[tuple[WorkClock, ...]] = ContextVar("running", default=())


@contextmanager
def counted_work(*, apart: bool = False, clock: WorkClock | None = None) -> Iterator[WorkClock]:
    """Count the work done inside the context, in this thread.

    Args:
        apart: Whether clocks that run already do not count it. They belong to another thread, which
            charges it when it has waited for this one: until then nobody knows how far it is.
        clock: Goes on from what it has counted before; a new one by default.
    """
    clock = WorkClock() if clock is None else clock
    before = _running.set((*(() if apart else _running.get()), clock))
    try:
        yield clock
    finally:
        _running.reset(before)


def charge(seconds: float) -> None:
    """Count some work on every clock that runs.

    Args:
        seconds: What it takes on an idle computer, in [s]: told by sizes, never measured.
    """
    exact = in_whole_ticks(seconds)
    for clock in _running.get():
        clock.seconds += exact


def in_whole_ticks(seconds: float) -> float:
    """Return seconds as a multiple of 2^-40 s.

    Sums of such numbers are exact, so that they do not depend on their order, nor on the parts in
    which something is charged.
    """
    return math.ldexp(round(math.ldexp(seconds, TICK_BITS)), -TICK_BITS)
