"""A tree that grows where cells are important, compiled as a whole.

Motions that lead nowhere new are mostly forgotten, so that the tree stays small; one that goes
through a new cell leaves a node there.

Source: Sucan, Kavraki, Kinodynamic motion planning by interior-exterior cell exploration, WAFR
2008.
"""

from __future__ import annotations

import math

import numpy as np

from kinolab.numerics.jit import kernel
from kinolab.numerics.rng import below, uniform
from kinolab.search.tree.cost_to_go import cell_at
from kinolab.search.tree.kpiece_grid import choose, clear_cells, holds, key_of, put, rate
from kinolab.search.tree.limits import keeps_limits
from kinolab.search.tree.problem_arrays import draw_input, excess
from kinolab.search.tree.tree import (
    FULL,
    GROWING,
    INSIDE,
    REACHED,
    insert_node,
    plant,
    step_is_free,
)
from kinolab.simulation.collision_context import fastest_at
from kinolab.simulation.machine import advance

KEPT = 0.05  # probability that a motion is kept that leads nowhere new


@kernel
def explore(  # type: ignore[no-untyped-def]
    search, tree, cells, leads, best, iterations, min_steps, max_steps, greed, tried,
):  # fmt: skip
    """Grow a tree by some iterations.

    Args:
        search: The problem, and scratch memory.
        tree: Grows.
        cells, leads: Over the problem's states.
        best: The node nearest to the goal, and its excess (2,); written.
        iterations: How many at most.
        min_steps, max_steps: For how many steps an input is held.
        greed: Power of the way to the goal by which cells count less.
        tried: Inputs of which that one is held which leads furthest to the goal.

    Returns:
        How it ended, and how many iterations were made.
    """
    now, after, u, random = tree.now, tree.after, tree.held, search.random
    for done in range(iterations):
        if tree.size[0] >= tree.x.shape[0]:
            return FULL, done
        cell, parent = choose(cells, random)
        steps = held_for(search, tree, leads, parent, min_steps, max_steps, tried)
        for i in range(now.shape[0]):
            now[i] = tree.x[parent, i]
        made, spare, new = 0, np.float64(tree.spare[parent]), False
        speed = fastest_at(search.machine, now, u, search.looks)
        for step in range(steps):
            room, speed = step_is_free(search, tree, now, u, after, spare, speed)
            if room < 0.0:
                break
            made, spare = made + 1, room
            for i in range(now.shape[0]):
                now[i] = after[i]
            if made < min_steps or tree.size[0] >= tree.x.shape[0]:
                continue
            share = excess(search, now, math.inf)
            far = leads.steps[cell_at(leads, now)]
            key = key_of(cells, search.question.goal, now, far)
            first = holds(cells, key) == 0
            if first or share <= INSIDE or (step == steps - 1 and uniform(random) < KEPT):
                parent = insert_node(tree, now, u, parent, made, spare)
                made, new = 0, new or first
                put(cells, key, parent, score(tree, far, greed))
                if share < best[1]:
                    best[0], best[1] = parent, share
                if share <= INSIDE:
                    return REACHED, done + 1
        rate(cells, cell, new)
    return GROWING, iterations


@kernel
def start_in_a_cell(search, tree, cells):  # type: ignore[no-untyped-def]
    """Leave nothing in the tree and its cells but the start."""
    question = search.question
    clear_cells(cells)
    node = plant(search, tree)
    put(cells, key_of(cells, question.goal, question.start, math.inf), node, 1.0)


@kernel
def score(tree, far, greed):  # type: ignore[no-untyped-def]
    """Return the score of a new cell: later ones count more, and those nearer to the goal."""
    return math.log(1.0 + tree.size[0]) / (1.0 + far) ** greed


@kernel
def held_for(search, tree, leads, parent, min_steps, max_steps, tried):  # type: ignore[no-untyped-def]
    """Write the input to hold from a node to ``tree.held``; return for how many steps."""
    least, longest, random = math.inf, 0, search.random
    for k in range(tried):
        draw_input(search.question, random, tree.drawn)
        steps, far = min_steps + below(random, max_steps - min_steps + 1), 0.0
        if tried > 1:
            far, steps = leads_to(search, tree, leads, parent, steps)
        if k == 0 or far < least:
            least, longest = far, max(steps, min_steps)
            for i in range(tree.held.shape[0]):
                tree.held[i] = tree.drawn[i]
    return longest


@kernel
def leads_to(search, tree, leads, parent, steps):  # type: ignore[no-untyped-def]
    """Return how far from the goal an input leads at best, obstacles apart, and after how long."""
    now, after, u = tree.now, tree.after, tree.drawn
    machine, question = search.machine, search.question
    for i in range(now.shape[0]):
        now[i] = tree.x[parent, i]
    least, at = math.inf, 1
    for step in range(steps):
        failed = advance(machine, now, u, question.step, after)
        if failed != 0 or not keeps_limits(question.limits, after):
            break
        for i in range(now.shape[0]):
            now[i] = after[i]
        far = leads.steps[cell_at(leads, now)]
        if far <= least:
            least, at = far, step + 1
    return least, at
