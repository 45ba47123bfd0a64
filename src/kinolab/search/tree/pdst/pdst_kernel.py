"""PDST kernel: a tree that grows from motions, in turns that a subdivision of space makes fair.

Each round grows the motion of the least score from a random state of it, doubles its priority, so
that others follow first, and halves its cell.

Source: Ladd, Kavraki, Motion planning in the presence of drift, underactuation and discrete system
changes, RSS 2005.
"""

from __future__ import annotations

import math

from kinolab.numerics.jit import kernel
from kinolab.numerics.rng import below
from kinolab.search.tree.flat_arrays import copy
from kinolab.search.tree.lanes import draw_control
from kinolab.search.tree.pdst.subdivision import (
    CELLS,
    NOTHING,
    ROUNDS,
    add_motion,
    cell_of,
    clear_motions,
    halved,
    put_into,
    settle,
)
from kinolab.search.tree.problem_arrays import goal_violation, is_inside
from kinolab.search.tree.tree import (
    FULL,
    GROWING,
    REACHED,
    begin_tree,
    insert_node,
    note_nearest,
    step_is_free,
)
from kinolab.simulation.collision_context import speed_bound
from kinolab.simulation.machine import advance


@kernel
def start_with_a_motion(search, tree, cells):  # type: ignore[no-untyped-def]
    """Clear the tree and its cells to the start, a motion of no length.

    Args:
        search, tree, cells: ``SearchState``, ``Tree`` and ``Subdivision``.
    """
    clear_motions(cells)
    add_motion(cells, begin_tree(search, tree), 0, 0.0)


@kernel
def grow_motions(search, tree, cells, best, iterations, min_steps, max_steps):  # type: ignore[no-untyped-def]
    """Grow a tree for some iterations.

    Args:
        search: The problem and scratch memory.
        tree: The tree; written.
        cells: ``Subdivision``; written.
        best: The node nearest to the goal and its normalised goal error (2,); written.
        iterations: Maximum number of iterations.
        min_steps, max_steps: Range of the control duration in steps.

    Returns:
        GROWING, REACHED or FULL, and the number of iterations made.
    """
    for done in range(iterations):
        if not has_room(tree, cells, max_steps):
            return FULL, done
        cells.counts[ROUNDS] += 1
        motion = cells.heap[0]
        cell = cells.cell[motion]
        cells.priority[motion] = 2.0 * cells.priority[motion] + 1.0
        settle(cells, motion)
        parent = begun_along(search, tree, cells, motion)
        if propagate_from(search, tree, cells, best, parent, min_steps, max_steps):
            return REACHED, done + 1
        # the volume of cells that were divided more often means nothing
        if cells.divisions[cell] < 60 and has_room(tree, cells, max_steps):
            divide(search, tree, cells, cell)
    return GROWING, iterations


@kernel
def has_room(tree, cells, more):  # type: ignore[no-untyped-def]
    """Say whether some ``more`` motions and two more cells can be kept.

    Args:
        tree, cells: ``Tree`` and ``Subdivision``.
        more: Number of motions.
    """
    room = tree.x.shape[0] - tree.size[0]
    return room > more + 1 and cells.counts[CELLS] + 2 <= cells.axis.shape[0]


@kernel
def begun_along(search, tree, cells, motion):  # type: ignore[no-untyped-def]
    """Return a node at a random state of a motion, which is divided there.

    Args:
        search, tree, cells: ``SearchState``, ``Tree`` and ``Subdivision``.
        motion: The node that it leads to.
    """
    steps = tree.steps[motion]
    if steps <= 1:
        return motion
    length = 1 + below(search.random, steps)
    if length == steps:
        return motion
    copy(tree.x[tree.parent[motion]], cells.at)
    for _ in range(length):
        forward(search, tree, cells, motion)
    return divided_at(tree, cells, motion, length, cells.cell[motion])


@kernel
def forward(search, tree, cells, motion):  # type: ignore[no-untyped-def]
    """Make a step of a motion from ``cells.at``, once more.

    Args:
        search, tree, cells: ``SearchState``, ``Tree`` and ``Subdivision``.
        motion: The node that it leads to.
    """
    advance(search.machine, cells.at, tree.u[motion], search.problem.step, cells.then)
    copy(cells.then, cells.at)


@kernel
def divided_at(tree, cells, motion, length, cell):  # type: ignore[no-untyped-def]
    """Add a node at ``cells.at``; return it. The rest of the motion keeps its own.

    Args:
        tree, cells: ``Tree`` and ``Subdivision``.
        motion: The node that the motion leads to.
        length: Number of steps along the motion to the new node.
        cell: That these steps lie in.
    """
    node = insert_node(tree, cells.at, tree.u[motion], tree.parent[motion], length, 0.0)
    tree.parent[motion], tree.steps[motion] = node, tree.steps[motion] - length
    add_motion(cells, node, cell, cells.priority[motion])
    return node


@kernel
def propagate_from(search, tree, cells, best, parent, min_steps, max_steps):  # type: ignore[no-untyped-def]
    """Apply a random input from a node, with a motion for each cell that is passed through.

    Args:
        search, tree, cells: ``SearchState``, ``Tree`` and ``Subdivision``.
        best: The node nearest to the goal and its normalised goal error (2,); written.
        parent: The node.
        min_steps, max_steps: Range of the control duration in steps.

    Returns:
        Whether its last state is in the goal.
    """
    now, after, u = tree.now, tree.after, tree.held
    steps = draw_control(search, u, min_steps, max_steps)
    copy(tree.x[parent], now)
    clearance = float(tree.clearance[parent])
    speed = speed_bound(search.machine, now, u, search.scratch)
    made, cell = 0, 0
    for _ in range(steps):
        known, speed = step_is_free(search, tree, now, u, after, clearance, speed)
        if known < 0.0:
            break
        reached = cell_of(cells, after)
        if made > 0 and reached != cell:
            parent = kept(search, tree, cells, best, parent, made, clearance, cell)
            made = 0
        made, cell, clearance = made + 1, reached, known
        copy(after, now)
        if is_inside(goal_violation(search, now, math.inf)):
            kept(search, tree, cells, best, parent, made, clearance, cell)
            return True
    if made > 0:
        kept(search, tree, cells, best, parent, made, clearance, cell)
    return False


@kernel
def kept(search, tree, cells, best, parent, made, clearance, cell):  # type: ignore[no-untyped-def]
    """Add the motion to ``tree.now`` to the tree and to its cell; return its node.

    Args:
        search, tree, cells: ``SearchState``, ``Tree`` and ``Subdivision``.
        best: The node nearest to the goal and its normalised goal error (2,); written.
        parent: The node that it begins at.
        made: Number of its steps.
        clearance: Clearance bound at its end in [m].
        cell: That it lies in.
    """
    node = insert_node(tree, tree.now, tree.held, parent, made, clearance)
    add_motion(cells, node, cell, float(cells.counts[ROUNDS]))
    note_nearest(best, node, goal_violation(search, tree.now, math.inf))
    return node


@kernel
def divide(search, tree, cells, cell):  # type: ignore[no-untyped-def]
    """Halve a cell, and its motions where they pass from one half into the other.

    Args:
        search, tree, cells: ``SearchState``, ``Tree`` and ``Subdivision``.
        cell: To be halved.
    """
    halved(cells, cell)
    motion = cells.first[cell]
    cells.first[cell] = NOTHING
    while motion != NOTHING:
        following = cells.following[motion]
        steps, length, side = tree.steps[motion], 0, cell_of(cells, tree.x[motion])
        if steps > 1:
            copy(tree.x[tree.parent[motion]], cells.at)
            forward(search, tree, cells, motion)
            length, side = 1, cell_of(cells, cells.at)
            for _ in range(steps - 1):
                advance(search.machine, cells.at, tree.u[motion], search.problem.step, cells.then)
                reached = cell_of(cells, cells.then)
                if reached != side and tree.size[0] < tree.x.shape[0]:
                    divided_at(tree, cells, motion, length, side)
                    length = 0
                length, side = length + 1, reached
                copy(cells.then, cells.at)
        put_into(cells, motion, side)
        settle(cells, motion)
        motion = following
