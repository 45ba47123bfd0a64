"""A worker: the same search in one thread or in several at once, each with its own data.

python -m versus.abreast PROBLEM PLANNER NODES ROUNDS THREADS

It says when it is ready and waits for the word to go.
"""

from __future__ import annotations

import json
import sys
import time
from concurrent.futures import ThreadPoolExecutor

from kinolab.search.tree import AbstractTreeExtension
from kinolab.search.tree.tree import ALL_STEPS

from .grow import PIECE, begun

SEED = 1  # of all: the work is the same, so that all end together


def grow(tree: AbstractTreeExtension, nodes: int, rounds: int) -> int:
    """Grow a tree to some nodes again and again; return the steps that were tried."""
    for _ in range(rounds):
        tree.begin()
        while tree.nodes.size[0] < nodes:
            tree.grow(PIECE)
    return int(tree.nodes.rejections[ALL_STEPS])


if __name__ == "__main__":
    problem, planner, nodes, rounds, threads = sys.argv[1:]
    searches = [begun(problem, planner, SEED) for _ in range(int(threads))]
    print("ready", flush=True)
    sys.stdin.readline()
    with ThreadPoolExecutor(len(searches)) as pool:
        first = time.monotonic()
        tried = sum(pool.map(lambda own: grow(own[1], int(nodes), int(rounds)), searches))
        last = time.monotonic()
    print(json.dumps({"begin": first, "end": last, "propagations": tried}))
