"""Ends of extensions that wait to be added to a tree."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel
from kinolab.search.tree.extensions import end_extension
from kinolab.search.tree.flat_arrays import copy


class Ends(NamedTuple):
    """Ends of extensions that are not in the tree yet, for compiled kernels."""

    x: Annotated[Array, "capacity", "nx"]
    u: Annotated[Array, "capacity", "nu"]
    parent: Annotated[Integers, "capacity"]
    made: Annotated[Integers, "capacity"]  # steps
    violation: Annotated[Array, "capacity"]  # normalised goal error
    clearance: Annotated[Array, "capacity"]  # in [m]
    filled: Annotated[Integers, 2]  # number of ends, and of those that were added


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
    copy(tree.now, ends.x[at])
    copy(tree.held, ends.u[at])
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
    copy(ends.x[at], tree.now)
    copy(ends.u[at], tree.held)
    return ends.parent[at], ends.made[at], ends.violation[at], ends.clearance[at]
