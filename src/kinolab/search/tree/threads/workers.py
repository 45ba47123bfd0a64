"""What each worker of a tree has to itself, and where what it finds waits to be added."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinolab.dynamics.codegen.integrators import LANES
from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel
from kinolab.numerics.struct import Own, Record
from kinolab.search.tree.extensions import end_extension
from kinolab.search.tree.sampled.witnesses import Witnesses
from kinolab.search.tree.tree import Tree
from kinolab.search.tree.tree_extension import SearchState

# Draws of a node to extend in a round: by the first half of the workers, and by the others. Short
# parts come last, so that nobody waits long for the end of a round.
LONG_PART, SHORT_PART = 24, 8
# Entries of a board, each in a cache line of its own.
TAKEN, OPENED, DONE, OVER = range(8, 40, 8)
BOARD_SIZE = 48

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


class Ends(NamedTuple):
    """Ends of extensions that are not in the tree yet, for compiled kernels."""

    x: Array  # (capacity, nx)
    u: Array  # (capacity, nu)
    parent: Integers  # (capacity,)
    made: Integers  # (capacity,) steps
    violation: Array  # (capacity,) normalised goal error
    clearance: Array  # (capacity,) in [m]
    filled: Integers  # (2,) number of ends, and of those that were added


class Worker(NamedTuple):
    """What one worker works with, for compiled kernels; nodes and their index are those of all."""

    search: SearchState
    tree: Tree
    witnesses: Witnesses  # of sparse trees
    ends: Ends


class Workers(NamedTuple):
    """Where the records of all workers are, for compiled kernels, and what is to do."""

    addresses: Integers  # (workers,)
    most: Integers  # (1,) steps that a solution must stay below
    board: Integers  # (BOARD_SIZE,)


def no_ends(nx: int, nu: int) -> Ends:
    """Allocate room for all that a worker can end in a round."""
    capacity = LONG_PART + LANES
    return Ends(
        x=np.zeros((capacity, nx)),
        u=np.zeros((capacity, nu)),
        parent=np.zeros(capacity, np.int64),
        made=np.zeros(capacity, np.int64),
        violation=np.zeros(capacity),
        clearance=np.zeros(capacity),
        filled=np.zeros(2, np.int64),
    )


def another(first: Record, number: int) -> Record:
    """Return the record of a worker of the same tree, with a number above 0.

    It has scratch memory and random numbers of its own.
    """
    record = first.apart(OWN)
    seed = np.random.SeedSequence([*map(int, first.held.search.random), number])
    record.held.search.random[:] = seed.generate_state(2, np.uint64)
    return record


@kernel
def keep_end(tree, lane, ends):  # type: ignore[no-untyped-def]
    """Make a lane idle whose extension has ended, and keep its end.

    Args:
        tree: Of a worker.
        lane: The lane.
        ends: ``Ends`` of that worker; written.
    """
    parent, made, violation, clearance = end_extension(tree, lane)
    at = ends.filled[0]
    ends.filled[0] += 1
    for i in range(tree.now.shape[0]):
        ends.x[at, i] = tree.now[i]
    for i in range(tree.held.shape[0]):
        ends.u[at, i] = tree.held[i]
    ends.parent[at], ends.made[at] = parent, made
    ends.violation[at], ends.clearance[at] = violation, clearance


@kernel
def take_end(tree, ends):  # type: ignore[no-untyped-def]
    """Take the next end that is kept, with its state and inputs in ``tree.now`` and ``tree.held``.

    Args:
        tree: Written.
        ends: Some are left.

    Returns:
        Parent, steps made, the normalised goal error at their end and the clearance there in [m].
    """
    at = ends.filled[1]
    ends.filled[1] += 1
    for i in range(tree.now.shape[0]):
        tree.now[i] = ends.x[at, i]
    for i in range(tree.held.shape[0]):
        tree.held[i] = ends.u[at, i]
    return ends.parent[at], ends.made[at], ends.violation[at], ends.clearance[at]
