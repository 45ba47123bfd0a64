"""The search tree in flat arrays: node insertion and checked propagation steps."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array, Integers, allocate
from kinolab.numerics.jit import kernel
from kinolab.numerics.neighbours.r_tree import RTree, r_tree
from kinolab.search.tree.flat_arrays import copy
from kinolab.search.tree.lanes import Extensions, LaneStates, drop_extensions
from kinolab.search.tree.problem_arrays import ProblemArrays, is_inside, metric_periods
from kinolab.simulation.collision_context import is_motion_free
from kinolab.simulation.limits import KEPT, passed_limit, slopes_of_step
from kinolab.simulation.machine import advance
from kinolab.simulation.propagator import COLLISION, EQUATIONS, LIMIT

GROWING, REACHED, FULL = 0, 1, 2  # status of growth: may continue, goal reached, capacity used
ALL_STEPS = 3  # index of the count of all steps, after those of rejections by cause
NONE = np.int64(-1)  # parent of the start; typed, since a literal would trigger recompilation
COST_UNIT = 1e-9  # of a cost that is a state, by which trees count in whole numbers as by steps


class Tree(NamedTuple):
    """Nodes in flat arrays, for compiled kernels; node 0 is the start."""

    x: Annotated[Array, "capacity", "nx"]
    u: Annotated[Array, "capacity", "nu"]  # input from the parent
    parent: Annotated[NDArray[np.int32], "capacity"]  # -1 for the start
    steps: Annotated[NDArray[np.int32], "capacity"]  # duration of the input
    cost: Annotated[Integers, "capacity"]  # steps from the start, or what these cost
    clearance: Annotated[NDArray[np.float32], "capacity"]  # lower bound of the clearance in [m]
    failures: Annotated[NDArray[np.int32], "capacity"]  # failed extensions
    cost_entry: int  # as the problem's arrays have it
    size: Annotated[Integers, 1]
    rejections: Annotated[Integers, 4]  # steps rejected by cause, and all steps
    neighbours: RTree
    point: Annotated[Array, "d"]  # scratch
    now: Annotated[Array, "nx"]  # scratch
    after: Annotated[Array, "nx"]  # scratch
    held: Annotated[Array, "nu"]  # scratch
    target: Annotated[Array, "nx"]  # scratch
    drawn: Annotated[Array, "nu"]  # scratch
    aim: Annotated[Array, "d"]  # scratch
    lanes: LaneStates
    extensions: Extensions


def tree(
    arrays: ProblemArrays, capacity: int, neighbours: bool = True, kept_steps: int = 0
) -> Tree:
    """Allocate an empty tree.

    Args:
        capacity: In nodes.
        neighbours: Whether it has an index of nearest neighbours.
        kept_steps: Of inputs that are compared, whose states are kept.
    """
    period = metric_periods(arrays)
    sizes = {"capacity": capacity, "steps": kept_steps, "d": len(period)}
    sizes |= {"nx": len(arrays.start), "nu": len(arrays.input_lower)}
    return allocate(
        Tree,
        sizes,
        neighbours=r_tree(capacity if neighbours else 1, period),
        cost_entry=arrays.cost_entry,
    )


@kernel
def insert_node(tree, x, u, parent, steps, known_clearance):  # type: ignore[no-untyped-def]
    """Add a node without indexing it; return its index.

    Args:
        tree: The tree; written.
        x, u: State (nx,), and the inputs (nu,) that led to it.
        parent, steps: Its parent, NONE for the start, and the number of steps from there.
        known_clearance: Clearance bound at x in [m].
    """
    node = tree.size[0]
    copy(x, tree.x[node])
    copy(u, tree.u[node])
    tree.parent[node], tree.steps[node] = parent, steps
    tree.cost[node] = cost_at(tree, parent, x, steps)
    # keeps clearances conservative in single precision
    tree.clearance[node] = known_clearance * (1.0 - 1e-6)
    tree.failures[node] = 0
    tree.size[0] += 1
    return node


@kernel
def cost_at(tree, parent, x, steps):  # type: ignore[no-untyped-def]
    """Return the cost of a state (nx,), so many steps from its parent, or NONE for the start."""
    if tree.cost_entry >= 0:
        return np.int64(x[tree.cost_entry] / COST_UNIT)
    return np.int64(steps + (tree.cost[parent] if parent >= 0 else 0))


@kernel
def note_nearest(best, node, violation):  # type: ignore[no-untyped-def]
    """Note a new node that is nearest to the goal; return REACHED if it is inside, or GROWING.

    Args:
        best: The node nearest to the goal and its normalised goal error (2,); written.
        node, violation: The new node, and its normalised goal error.
    """
    if violation < best[1]:
        best[0], best[1] = node, violation
    return REACHED if is_inside(violation) else GROWING


@kernel
def step_is_free(search, tree, x, u, after, known_clearance, speed):  # type: ignore[no-untyped-def]
    """Propagate a step from x under u into ``after``, check it, and count a rejection by cause.

    Args:
        search, tree: ``SearchState`` and ``Tree``.
        x, u: State (nx,) and inputs (nu,).
        after: The state reached, shape (nx,); written.
        known_clearance: Clearance bound at x in [m].
        speed: Speed bound of the fastest point at x, in [m/s].

    Returns:
        Clearance bound at ``after`` in [m], negative if the step is rejected, and the speed there,
        as ``is_motion_free``.
    """
    machine, h = search.machine, search.problem.step
    tree.rejections[ALL_STEPS] += 1
    if advance(machine, x, u, h, after) != 0:
        tree.rejections[EQUATIONS] += 1
        return -1.0, 0.0
    slopes_of_step(machine, search.problem.limits, x, u, after)
    return made_step_is_free(search, tree, x, u, after, known_clearance, speed)


@kernel
def made_step_is_free(search, tree, x, u, after, known_clearance, speed):  # type: ignore[no-untyped-def]
    """Check a step that was made, whose slopes are known, as ``step_is_free`` does.

    Args:
        search, tree: ``SearchState`` and ``Tree``.
        x, u, after: State (nx,), inputs (nu,) and the state reached (nx,).
        known_clearance, speed: As ``step_is_free`` takes them.
    """
    machine, scratch, h = search.machine, search.scratch, search.problem.step
    if passed_limit(machine, search.problem.limits, x, u, after, h, scratch) != KEPT:
        tree.rejections[LIMIT] += 1
        return -1.0, 0.0
    known_clearance, speed = is_motion_free(
        machine, x, u, after, h, known_clearance, speed, scratch, search.collision
    )
    if known_clearance < 0.0:
        tree.rejections[COLLISION] += 1
    return known_clearance, speed


@kernel
def begin_tree(search, tree):  # type: ignore[no-untyped-def]
    """Clear a tree to its start, which is in no index; return that node."""
    tree.size[0] = 0
    drop_extensions(tree.extensions)
    tree.held[:] = 0.0
    return insert_node(tree, search.problem.start, tree.held, NONE, np.int64(0), 0.0)


def controls_to(tree: Tree, node: int) -> Array:
    """Return the inputs from the start to a node, one row per step, shape (steps, nu)."""
    nodes = []
    while tree.parent[node] >= 0:
        nodes.append(node)
        node = int(tree.parent[node])
    nodes.reverse()
    return np.repeat(tree.u[nodes], tree.steps[nodes], axis=0)


def nearer(tree: Tree, best: Array, violation: float, u: Array) -> tuple[float, Array]:
    """Return the tree's nearest approach to the goal or a given motion, whichever is nearer.

    Args:
        best: The node nearest to the goal and its normalised goal error, shape (2,).
        violation: Normalised goal error of the given motion.
        u: Inputs of the given motion, shape (N, nu).
    """
    if best[1] < violation:
        return float(best[1]), controls_to(tree, int(best[0]))
    return violation, u


def step_counts(tree: Tree) -> dict[str, float]:
    """Return the counts of nodes, steps and rejected steps by cause, by name."""
    named = {"limit": LIMIT, "collision": COLLISION, "equations": EQUATIONS}
    refused = {f"rejected_by_{cause}": float(tree.rejections[k]) for cause, k in named.items()}
    return refused | {
        "propagations": float(tree.rejections[ALL_STEPS]),
        "nodes": float(tree.size[0]),
    }
