"""Growth of one tree in rounds: workers extend the tree as it is, then all that ended is added.

A worker is not a thread: whoever is free does the part of the next one, and what comes of a round
does not depend on who did what. So a tree depends on the number of its workers alone, neither on
that of processors nor on how busy they are.

Source: Perrault, Ho, Lahijanian, Kino-PAX: highly parallel kinodynamic sampling-based planner, IEEE
Robotics and Automation Letters 10(3), 2025, for rounds of extensions of the tree as it is.
"""

from __future__ import annotations

import numpy as np

from kinolab.numerics.jit import kernel
from kinolab.search.tree.extensions import take_end
from kinolab.search.tree.lanes import drop_extensions
from kinolab.search.tree.sampled.sampled_growth import add_end, grow, is_full
from kinolab.search.tree.threads.atomics import (
    atomic_add,
    atomic_load,
    atomic_store,
    compare_and_swap,
    record_at,
    yield_processor,
)
from kinolab.search.tree.threads.workers import (
    DONE,
    LONG_PART,
    OPENED,
    OVER,
    SHORT_PART,
    TAKEN,
)
from kinolab.search.tree.tree import FULL, GROWING

NO_PART = np.int64(-1)


@kernel
def grow_in_rounds(first, workers, iterations):  # type: ignore[no-untyped-def]
    """Grow a tree for some iterations or a few more, beside those who help.

    Args:
        first: Record of the first ``Worker``, who adds nodes.
        workers: ``Workers``.
        iterations: Number after which no other round begins.

    Returns:
        GROWING, REACHED or FULL, and the number of iterations made.
    """
    done, board, crowd = 0, workers.board, workers.addresses.shape[0]
    while True:
        status = add_ends(first, workers)
        if status != GROWING or done >= iterations:
            return status, done
        atomic_store(board, OPENED, atomic_load(board, OPENED) + crowd)
        while True:
            part = take_part(board)
            if part == NO_PART:
                break
            do_part(part % crowd, first, workers)
        while atomic_load(board, DONE) != atomic_load(board, OPENED):
            yield_processor()
        for worker in range(crowd):
            done += draws_of(worker, workers)


@kernel
def help_growing(first, workers):  # type: ignore[no-untyped-def]
    """Do parts of the rounds of a tree until there are none for a while.

    Args:
        first, workers: As ``grow_in_rounds`` takes them.
    """
    board, crowd, idle = workers.board, workers.addresses.shape[0], 0
    # looks for a part, a fraction of a microsecond each, before a thread sleeps
    while idle < 1000 and atomic_load(board, OVER) == 0:
        part = take_part(board)
        if part == NO_PART:
            idle += 1
            yield_processor()
        else:
            idle = 0
            do_part(part % crowd, first, workers)


@kernel
def take_part(board):  # type: ignore[no-untyped-def]
    """Take a part of the round that nobody has taken, NO_PART if none is left."""
    while True:
        taken = atomic_load(board, TAKEN)
        if taken >= atomic_load(board, OPENED):
            return NO_PART
        if compare_and_swap(board, TAKEN, taken, taken + 1):
            return taken


@kernel
def do_part(number, first, workers):  # type: ignore[no-untyped-def]
    """Extend the tree as one of its workers.

    Args:
        number: Of the worker.
        first, workers: As ``grow_in_rounds`` takes them.
    """
    worker = record_at(workers.addresses[number], first)
    grow(worker, draws_of(number, workers), True)
    atomic_add(workers.board, DONE, 1)


@kernel
def draws_of(number, workers):  # type: ignore[no-untyped-def]
    """Return how often the worker of a number draws a node to extend in a round."""
    return LONG_PART if 2 * number < workers.addresses.shape[0] else SHORT_PART


@kernel
def add_ends(first, workers):  # type: ignore[no-untyped-def]
    """Add what all workers keep to the tree, up to one that reaches the goal.

    Args:
        first, workers: As ``grow_in_rounds`` takes them.

    Returns:
        GROWING, REACHED or FULL.
    """
    for number in range(workers.addresses.shape[0]):
        ends = record_at(workers.addresses[number], first).ends
        while ends.filled[1] < ends.filled[0]:
            before = first.tree.size[0]
            if is_full(first):
                return FULL
            if first.tree.size[0] < before:
                abandon(first, workers)
                return GROWING
            status = add_end(first, *take_end(first.tree, ends))
            if status != GROWING:
                return status
        ends.filled[0] = ends.filled[1] = 0
    return GROWING


@kernel
def abandon(first, workers):  # type: ignore[no-untyped-def]
    """Give up all extensions, under way or ended: a tree was cleared, or its nodes renumbered.

    Args:
        first: Record of the first ``Worker``.
        workers: ``Workers``.
    """
    for number in range(workers.addresses.shape[0]):
        worker = record_at(workers.addresses[number], first)
        worker.ends.filled[0] = worker.ends.filled[1] = 0
        drop_extensions(worker.tree.extensions)
