"""What each worker of a tree has to itself, and where what it finds waits to be added."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.integrators import LANES
from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel
from kinolab.numerics.neighbours.r_tree import RTree
from kinolab.numerics.struct import address_of
from kinolab.search.tree.extensions import end_extension
from kinolab.search.tree.tree import Tree
from kinolab.search.tree.tree_extension import SearchState
from kinolab.search.tree.witnesses import Witnesses

# Draws of a node to extend in a round: by the first half of the workers, and by the others. Short
# parts come last, so that nobody waits long for the end of a round.
LONG_PART, SHORT_PART = 24, 8
# Entries of a board, each in a cache line of its own.
TAKEN, OPENED, DONE, OVER = range(0, 32, 8)
BOARD_SIZE = 32
LINE = 64  # bytes of a processor's cache that threads share or do not share

OWN_OF_TREE = (
    *("rejections", "point", "now", "after", "held", "target", "drawn", "aim"),
    *("lanes", "extensions"),
)

T = TypeVar("T", bound=tuple[Any, ...])


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


def another(worker: Worker, number: int) -> Worker:
    """Return a worker of the same tree with scratch memory and random numbers of its own."""
    search, tree, witnesses, ends = worker
    seed = np.random.SeedSequence([*map(int, search.random), number])
    limits = apart(search.problem.limits, "rates", "margins", "slope", "beside")
    search = search._replace(
        problem=search.problem._replace(limits=limits),
        random=seed.generate_state(2, np.uint64).astype(np.uint64),
    )
    tree = tree._replace(neighbours=_with_query(tree.neighbours))
    return Worker(
        apart(search, "scratch", "random"),
        apart(tree, *OWN_OF_TREE),
        witnesses._replace(neighbours=_with_query(witnesses.neighbours)),
        apart(ends),
    )


def _with_query(neighbours: RTree) -> RTree:
    return apart(neighbours, "query", "keys", "last", "path")


def apart(held: T, *names: str) -> T:
    """Return a tuple with copies of some arrays, and of all in some tuples of it.

    They share no cache line with anything else: threads that write to one line wait for each other.

    Args:
        held: A named tuple.
        names: Of its arrays and tuples; all if none is given.
    """
    fields: Any = held
    chosen = {name: getattr(fields, name) for name in names or fields._fields}
    memory = np.empty(sum(map(_room, chosen.values())) + LINE, np.uint8)
    at = -address_of(memory) % LINE
    for name, value in chosen.items():
        chosen[name] = _copy(value, memory[at:])
        at += _room(value)
    moved: T = fields._replace(**chosen)
    return moved


def _room(value: Any) -> int:
    """Return the bytes of the cache lines of an array, or of all in a tuple."""
    if isinstance(value, tuple):
        return sum(map(_room, value))
    return -(-value.nbytes // LINE) * LINE if isinstance(value, np.ndarray) else 0


def _copy(value: Any, memory: NDArray[np.uint8]) -> Any:
    """Copy an array, or all in a tuple, to memory (bytes,)."""
    if isinstance(value, np.ndarray):
        own = memory[: value.nbytes].view(value.dtype).reshape(value.shape)
        own[...] = value
        return own
    if not isinstance(value, tuple):
        return value
    copies = []
    for part in value:
        copies.append(_copy(part, memory))
        memory = memory[_room(part) :]
    return type(value)(*copies)


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
