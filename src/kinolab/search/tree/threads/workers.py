"""What each worker of a tree has to itself, and the board that says what is to do."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinolab.dynamics.codegen.integrators import LANES
from kinolab.numerics.arrays import Integers
from kinolab.numerics.struct import Own, Record

# Draws of a node to extend in a round: by the first half of the workers, and by the others. Short
# parts come last, so that nobody waits long for the end of a round.
LONG_PART, SHORT_PART = 24, 8
# Entries of a board, each in a cache line of its own.
TAKEN, OPENED, DONE, OVER = range(8, 40, 8)
BOARD_SIZE = 48
MOST_ENDS = LONG_PART + LANES  # of extensions of one worker in a round

_QUERY: Own = {name: {} for name in ("query", "keys", "last", "path")}
# What each worker has to itself: all that is written while the tree is extended.
OWN: Own = {
    "search": {
        "problem": {"limits": {name: {} for name in ("rates", "margins", "slope", "beside")}},
        "scratch": {},
        "random": {},
    },
    "tree": {
        **{name: {} for name in ("rejections", "point", "now", "after", "held", "target")},
        **{name: {} for name in ("drawn", "aim", "lanes", "extensions")},
        "neighbours": _QUERY,
    },
    "witnesses": {"neighbours": _QUERY},
    "ends": {},
}


class Workers(NamedTuple):
    """Where the records of all workers are, for compiled kernels, and what is to do."""

    addresses: Integers  # (workers,)
    board: Integers  # (BOARD_SIZE,)


def another(first: Record, number: int) -> Record:
    """Return the record of a worker of the same tree, with a number above 0.

    It has scratch memory and random numbers of its own.
    """
    record = first.apart(OWN)
    seed = np.random.SeedSequence([*map(int, first.held.search.random), number])
    record.held.search.random[:] = seed.generate_state(2, np.uint64)
    return record
