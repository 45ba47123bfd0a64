"""A worker: what a tree of kinolab's has cost when it has so many nodes.

python -m versus.grow PROBLEM PLANNER SEED LIMIT NODES ...
"""

from __future__ import annotations

import json
import sys
import time

from memory import resident

from kinolab.problem import PlanningTask
from kinolab.search.tree import AbstractCompiledPlanner, AbstractTreeExtension, search_state
from kinolab.search.tree.tree import ALL_STEPS

from .ours import UNREACHABLE, load, make
from .runs import KINOLAB, LIKE, Entrant

PIECE = 100  # iterations between two looks at the size


def begun(problem: str, planner: str, seed: int) -> tuple[PlanningTask, AbstractTreeExtension]:
    """Return a problem whose goal cannot be reached, and its tree with nothing but the start.

    The problem owns the code that grows the tree.
    """
    question, searcher = load(problem, UNREACHABLE), make(Entrant(KINOLAB, planner, LIKE[planner]))
    assert isinstance(searcher, AbstractCompiledPlanner)
    tree = searcher.extension(question, search_state(question, searcher.goal_region_scale, seed))
    tree.begin()
    tree.grow(PIECE)  # code is compiled and loaded
    tree.begin()
    tree.nodes.rejections[:] = 0
    return question, tree


def marks(tree: AbstractTreeExtension, sizes: list[int], limit: float) -> list[dict[str, float]]:
    """Grow a tree to the last of some sizes, as far as the limit in [s] allows."""
    cpu0, found = time.process_time(), []
    for size in (1, *sizes):
        while tree.nodes.size[0] < size and time.process_time() - cpu0 < limit:
            tree.grow(PIECE)
        if tree.nodes.size[0] < size:
            break
        mark = {"nodes": int(tree.nodes.size[0]), "cpu": time.process_time() - cpu0}
        found.append(
            {**mark, "resident": resident(), "propagations": int(tree.nodes.rejections[ALL_STEPS])}
        )
    return found


if __name__ == "__main__":
    given = sys.argv[1:]
    problem, tree = begun(given[0], given[1], int(given[2]))
    print(json.dumps({"marks": marks(tree, [int(size) for size in given[4:]], float(given[3]))}))
