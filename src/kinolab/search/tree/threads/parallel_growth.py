"""Growth of one tree in rounds: workers extend the tree as it is, then all that ended is added.

A worker is not a thread: whoever is free does the part of the next one, and what comes of a round
does not depend on who did what. So a tree depends on the number of its workers alone, neither on
that of processors nor on how busy they are.

Source: Perrault, Ho, Lahijanian, Kino-PAX: highly parallel kinodynamic sampling-based planner, IEEE
Robotics and Automation Letters 10(3), 2025, for rounds of extensions of the tree as it is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinolab.numerics.jit import kernel
from kinolab.search.tree.extensions import begin_extension, has_ended, lane_to_serve
from kinolab.search.tree.lanes import drop_extensions
from kinolab.search.tree.sampled.directed_control import add_end, directed_control, draw_node
from kinolab.search.tree.sampled.sampled_growth import add_end_sparsely, draw_sparsely
from kinolab.search.tree.sampled.witnesses import begin_witnesses, sweep
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
    keep_end,
    take_end,
)
from kinolab.search.tree.tree import FULL, GROWING, NONE, begin, begin_without_neighbours
from kinolab.search.tree.tree_extension import UNBOUNDED_STEPS

NO_PART = np.int64(-1)
PATIENCE = 1000  # looks for a part, a fraction of a microsecond each, before a thread sleeps


class Growth(NamedTuple):
    """How a tree grows, for compiled kernels; the last four are of sparse trees."""

    goal_bias: float  # probability of sampling the goal
    control_samples: int  # candidate inputs, of which the one leading nearest is applied
    min_steps: int  # of an input
    max_steps: int
    sparse: int = 0  # whether it is one
    selection_radius: float = 0.0
    improving_radius: float = 0.0  # the same, where a motion is known
    pruning_radius: float = 0.0


@kernel
def begin_apart(first, workers, growth):  # type: ignore[no-untyped-def]
    """Clear a tree to its start.

    Args:
        first: Record of the first ``Worker``.
        workers: ``Workers``.
        growth: ``Growth``.
    """
    if growth.sparse:
        begin_without_neighbours(first.search, first.tree)
        begin_witnesses(first.search, first.tree, first.witnesses)
    else:
        begin(first.search, first.tree)
    abandon(first, workers)


@kernel
def grow_in_rounds(first, workers, best, growth, iterations):  # type: ignore[no-untyped-def]
    """Grow a tree for some iterations or a few more, beside those who help.

    Args:
        first: Record of the first ``Worker``, who adds nodes.
        workers: ``Workers``.
        best: The node nearest to the goal and its normalised goal error (2,); written.
        growth: ``Growth``.
        iterations: Number after which no other round begins.

    Returns:
        GROWING, REACHED or FULL, and the number of iterations made.
    """
    done, board, crowd = 0, workers.board, workers.addresses.shape[0]
    while True:
        status = add_ends(first, workers, best, growth)
        if status != GROWING or done >= iterations:
            return status, done
        atomic_store(board, OPENED, atomic_load(board, OPENED) + crowd)
        while True:
            part = take_part(board)
            if part == NO_PART:
                break
            do_part(part % crowd, first, workers, best, growth)
        while atomic_load(board, DONE) != atomic_load(board, OPENED):
            yield_processor()
        for worker in range(crowd):
            done += draws_of(worker, workers)


@kernel
def help_growing(first, workers, best, growth):  # type: ignore[no-untyped-def]
    """Do parts of the rounds of a tree until there are none for a while.

    Args:
        first, workers, best, growth: As ``grow_in_rounds`` takes them.
    """
    board, crowd, idle = workers.board, workers.addresses.shape[0], 0
    while idle < PATIENCE and atomic_load(board, OVER) == 0:
        part = take_part(board)
        if part == NO_PART:
            idle += 1
            yield_processor()
        else:
            idle = 0
            do_part(part % crowd, first, workers, best, growth)


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
def do_part(number, first, workers, best, growth):  # type: ignore[no-untyped-def]
    """Extend the tree as one of its workers.

    Args:
        number: Of the worker.
        first, workers, best, growth: As ``grow_in_rounds`` takes them.
    """
    worker = record_at(workers.addresses[number], first)
    extend_apart(worker, best, growth, workers.most[0], draws_of(number, workers))
    atomic_add(workers.board, DONE, 1)


@kernel
def draws_of(number, workers):  # type: ignore[no-untyped-def]
    """Return how often the worker of a number draws a node to extend in a round."""
    return LONG_PART if 2 * number < workers.addresses.shape[0] else SHORT_PART


@kernel
def extend_apart(worker, best, growth, most, draws):  # type: ignore[no-untyped-def]
    """Extend a tree that others read, and keep the ends.

    Args:
        worker: Record of a ``Worker``.
        best: The node nearest to the goal and its normalised goal error (2,).
        growth: ``Growth``.
        most: Cost bound: steps that a solution must stay below.
        draws: Of a node to extend.
    """
    search, tree, done = worker.search, worker.tree, 0
    radius = growth.selection_radius if most == UNBOUNDED_STEPS else growth.improving_radius
    while True:
        lane = lane_to_serve(search, tree, growth.min_steps, best[1])
        if has_ended(tree, lane):
            keep_end(tree, lane, worker.ends)
            continue
        if done >= draws:
            return
        done += 1
        tree.extensions.draws[lane] += 1
        if growth.sparse:
            parent = draw_sparsely(search, tree, worker.witnesses, growth.goal_bias, radius)
        else:
            parent = draw_node(search, tree, growth.goal_bias)
        if parent != NONE:
            least, longest = growth.min_steps, growth.max_steps
            steps = directed_control(search, tree, parent, least, longest, growth.control_samples)
            steps = min(steps, most - 1 - tree.cost[parent])
            begin_extension(search, tree, lane, parent, steps)


@kernel
def add_ends(first, workers, best, growth):  # type: ignore[no-untyped-def]
    """Add what all workers keep to the tree, up to one that reaches the goal.

    Args:
        first, workers, best, growth: As ``grow_in_rounds`` takes them.

    Returns:
        GROWING, REACHED or FULL.
    """
    search, tree, witnesses, most = first.search, first.tree, first.witnesses, workers.most[0]
    for number in range(workers.addresses.shape[0]):
        ends = record_at(workers.addresses[number], first).ends
        while ends.filled[1] < ends.filled[0]:
            if tree.size[0] >= tree.x.shape[0]:
                if not (growth.sparse and sweep(tree, witnesses, best, most)):
                    return FULL
                abandon(first, workers)
                return GROWING
            parent, made, violation, clearance = take_end(tree, ends)
            if growth.sparse:
                status = add_end_sparsely(
                    search, tree, witnesses, best, growth.min_steps, most,
                    growth.pruning_radius, parent, made, violation, clearance,
                )  # fmt: skip
            else:
                status = add_end(
                    search, tree, best, growth.min_steps, parent, made, violation, clearance
                )
            if status != GROWING:
                return status
        ends.filled[0] = ends.filled[1] = 0
    return GROWING


@kernel
def prune(first, workers, best):  # type: ignore[no-untyped-def]
    """Prune nodes of a sparse tree that cannot lead to a motion of fewer steps than its bound.

    Args:
        first, workers, best: As ``grow_in_rounds`` takes them.
    """
    sweep(first.tree, first.witnesses, best, workers.most[0])
    abandon(first, workers)


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
