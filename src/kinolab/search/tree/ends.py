"""Ends of extensions that wait to be added to a tree."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel
from kinolab.search.tree.extensions import end_extension


class Ends(NamedTuple):
    """Ends of extensions that are not in the tree yet, for compiled kernels."""

    x: Array  # (capacity, nx)
    u: Array  # (capacity, nu)
    parent: Integers  # (capacity,)
    made: Integers  # (capacity,) steps
    violation: Array  # (capacity,) normalised goal error
    clearance: Array  # (capacity,) in [m]
    filled: Integers  # (2,) number of ends, and of those that were added


def no_ends(nx: int, nu: int, capacity: int) -> Ends:
    """Allocate room for some ends."""
    return Ends(
        x=np.zeros((capacity, nx)),
        u=np.zeros((capacity, nu)),
        parent=np.zeros(capacity, np.int64),
        made=np.zeros(capacity, np.int64),
        violation=np.zeros(capacity),
        clearance=np.zeros(capacity),
        filled=np.zeros(2, np.int64),
    )


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
