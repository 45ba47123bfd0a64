"""A worker: how long it takes from the definition of a machine to the first node of a tree.

python -m versus.first_node PROBLEM PLANNER
"""

from __future__ import annotations

import time

begun = time.perf_counter()

import json  # noqa: E402
import sys  # noqa: E402

from kinolab.search.tree import AbstractCompiledPlanner, search_state  # noqa: E402

from .ours import load, make  # noqa: E402
from .runs import KINOLAB, Entrant  # noqa: E402

if __name__ == "__main__":
    problem_name, planner_name = sys.argv[1:]
    planner = make(Entrant(KINOLAB, planner_name))
    assert isinstance(planner, AbstractCompiledPlanner)
    imported = time.perf_counter()
    problem = load(problem_name)
    defined = time.perf_counter()
    tree = planner.extension(problem, search_state(problem, planner.goal_region_scale, 1))
    tree.begin()
    while tree.nodes.size[0] < 2:
        tree.grow(1)
    done = time.perf_counter()
    spans = {"imports": imported - begun, "machine": defined - imported, "search": done - defined}
    print(json.dumps(spans))
