"""A tree of states that grows under held inputs: its memory, and how a motion is added to it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel
from kinolab.numerics.kd_forest import (
    Integers,
    KdForest,
    add,
    clear,
    kd_forest,
)
from kinolab.search.tree.limits import step_keeps_limits
from kinolab.search.tree.problem_arrays import ProblemArrays, metric_coordinates, metric_periods
from kinolab.simulation.collision_context import is_motion_free
from kinolab.simulation.machine import advance

GROWING, REACHED, FULL = 0, 1, 2  # how growth ends: it could go on, is in the goal, or has no room
# share of the goal's tolerance that counts, so that rounding cannot miss it
TOLERANCE_FRACTION = 0.999
LIMIT, COLLISION, EQUATIONS = 0, 1, 2  # why steps are refused, as ``Tree.rejections`` counts them
ALL_STEPS = 3  # where all steps are counted
NONE = np.int64(-1)  # the parent of the start; no literal, for which all would be compiled anew
ROUNDING_FACTOR = 1.0 - 1e-6  # so that single precision does not add any room


class Tree(NamedTuple):
    """Nodes in flat arrays, for compiled code; node 0 is the start."""

    x: Array  # (capacity, nx)
    u: Array  # (capacity, nu) held on the way from the parent
    parent: NDArray[np.int32]  # (capacity,) -1 for the start
    steps: NDArray[np.int32]  # (capacity,) for which the input was held
    cost: Integers  # (capacity,) steps from the start
    clearance: NDArray[np.float32]  # (capacity,) room in [m], as far as it is known
    failures: NDArray[np.int32]  # (capacity,) motions from there that came to nothing
    size: Integers  # (1,)
    rejections: Integers  # (4,) steps: refused, by cause, and all
    forest: KdForest
    point: Array  # (d,) scratch
    now: Array  # (nx,) scratch
    after: Array  # (nx,) scratch
    held: Array  # (nu,) scratch
    target: Array  # (nx,) scratch
    drawn: Array  # (nu,) scratch
    aim: Array  # (d,) scratch


def tree(arrays: ProblemArrays, capacity: int, neighbours: bool = True) -> Tree:
    """Return a tree without nodes that has room for so many; the nearest of them can be found."""
    nx, nu = len(arrays.start), len(arrays.input_lower)
    return Tree(
        x=np.zeros((capacity, nx)),
        u=np.zeros((capacity, nu)),
        parent=np.zeros(capacity, np.int32),
        steps=np.zeros(capacity, np.int32),
        cost=np.zeros(capacity, np.int64),
        clearance=np.zeros(capacity, np.float32),
        failures=np.zeros(capacity, np.int32),
        size=np.zeros(1, np.int64),
        rejections=np.zeros(4, np.int64),
        forest=kd_forest(capacity if neighbours else 1, metric_periods(arrays)),
        point=np.zeros(len(arrays.entry)),
        now=np.zeros(nx),
        after=np.zeros(nx),
        held=np.zeros(nu),
        target=np.zeros(nx),
        drawn=np.zeros(nu),
        aim=np.zeros(len(arrays.entry)),
    )


@kernel
def insert_node(tree, x, u, parent, steps, known_clearance):  # type: ignore[no-untyped-def]
    """Add a node that is no neighbour of any; return its number.

    Args:
        tree: Grows.
        x, u: State (nx,), and the inputs (nu,) that led to it.
        parent, steps: From where, NONE for the start, and in how many steps.
        known_clearance: Room at x in [m].
    """
    node = tree.size[0]
    for i in range(x.shape[0]):
        tree.x[node, i] = x[i]
    for i in range(u.shape[0]):
        tree.u[node, i] = u[i]
    tree.parent[node], tree.steps[node] = parent, steps
    tree.cost[node] = steps + (tree.cost[parent] if parent >= 0 else 0)
    tree.clearance[node] = known_clearance * ROUNDING_FACTOR
    tree.failures[node] = 0
    tree.size[0] += 1
    return node


@kernel
def insert(search, tree, x, u, parent, steps, known_clearance):  # type: ignore[no-untyped-def]
    """Add a node; return its number.

    Args:
        search, tree: ``SearchState`` and ``Tree``.
        x, u, parent, steps, known_clearance: As ``insert_node`` takes them.
    """
    node = insert_node(tree, x, u, parent, steps, known_clearance)
    metric_coordinates(search.problem, x, tree.point)
    add(tree.forest, tree.point)
    return node


@kernel
def step_is_free(search, tree, x, u, after, known_clearance, speed):  # type: ignore[no-untyped-def]
    """Make a step from x under u into ``after``, and count why it may not be made.

    Args:
        search, tree: ``SearchState`` and ``Tree``.
        x, u: State (nx,) and inputs (nu,).
        after: The state reached, shape (nx,); written.
        known_clearance: Room at x in [m], as far as it is known.
        speed: That of the fastest point at x, in [m/s].

    Returns:
        Room at ``after`` in [m], negative where the step is refused; and the speed there, as
        ``is_motion_free``.
    """
    machine, scratch, h = search.machine, search.scratch, search.problem.step
    tree.rejections[ALL_STEPS] += 1
    if advance(machine, x, u, h, after) != 0:
        tree.rejections[EQUATIONS] += 1
        return -1.0, 0.0
    if not step_keeps_limits(machine, search.problem.limits, x, u, after, h, scratch):
        tree.rejections[LIMIT] += 1
        return -1.0, 0.0
    known_clearance, speed = is_motion_free(
        machine, x, u, after, h, known_clearance, speed, scratch, search.collision
    )
    if known_clearance < 0.0:
        tree.rejections[COLLISION] += 1
    return known_clearance, speed


@kernel
def begin(search, tree):  # type: ignore[no-untyped-def]
    """Leave nothing in a tree but the start."""
    clear(tree.forest)
    tree.size[0] = 0
    tree.held[:] = 0.0
    insert(search, tree, search.problem.start, tree.held, NONE, np.int64(0), 0.0)


@kernel
def begin_without_neighbours(search, tree):  # type: ignore[no-untyped-def]
    """Leave nothing but the start, which is returned, in a tree without neighbours."""
    tree.size[0] = 0
    tree.held[:] = 0.0
    return insert_node(tree, search.problem.start, tree.held, NONE, np.int64(0), 0.0)


def controls_to(tree: Tree, node: int) -> Array:
    """Return the inputs from the start to a node, one row per step, shape (steps, nu)."""
    held = []
    while tree.parent[node] >= 0:
        held.append(np.repeat(tree.u[node][None], tree.steps[node], axis=0))
        node = int(tree.parent[node])
    return np.concatenate(held[::-1]) if held else np.zeros((0, tree.u.shape[1]))


def nearer(tree: Tree, best: Array, violation: float, u: Array) -> tuple[float, Array]:
    """Return the motion that ends nearest to the goal, if it is nearer than another one.

    Args:
        tree: With the motion's nodes.
        best: The node nearest to the goal, and how far outside it is, shape (2,).
        violation: How far outside the goal the other motion ends.
        u: Inputs of the other motion, shape (N, nu).
    """
    if best[1] < violation:
        return float(best[1]), controls_to(tree, int(best[0]))
    return violation, u


def step_counts(tree: Tree) -> dict[str, float]:
    """Return the steps that were made and those refused by cause, and the nodes, by name."""
    named = {"limit": LIMIT, "collision": COLLISION, "equations": EQUATIONS}
    refused = {f"rejected_by_{cause}": float(tree.rejections[k]) for cause, k in named.items()}
    return refused | {
        "propagations": float(tree.rejections[ALL_STEPS]),
        "nodes": float(tree.size[0]),
    }
