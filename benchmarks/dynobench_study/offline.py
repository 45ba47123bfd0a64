"""What a machine costs before the first search: ``python -m dynobench_study.offline FILE``.

It prints the seconds of this thread from an environment to a problem whose equations of motion are
derived and compiled; the folder of kept machines must be empty, and imports do not count. The
loops that serve all machines alike are compiled once per installation, by ``plan warm-up``.
"""

from __future__ import annotations

import sys
import time

import kinolab
import kinolab.loading
import kinolab.scenario.dynobench  # it comes with the first environment
from kinolab.simulation.machine import states_under


def seconds(file: str) -> float:
    """Return how long loading takes until the machine has made a step."""
    begun = time.thread_time()
    problem = kinolab.load(file)
    states_under(problem, problem.model.control_bounds.mean(axis=1)[None])
    return time.thread_time() - begun


if __name__ == "__main__":
    print(seconds(sys.argv[1]))
