"""One search in a process of its own: ``python -m dynobench_study.worker FILE NAME SEED LIMIT``.

It prints one line of JSON: the run. The last argument may be a planner's name.
"""

from __future__ import annotations

import json
import sys
import time
from dataclasses import asdict, replace
from pathlib import Path

from .judgement import judge
from .records import Run
from .search import load, search
from .strict import strictly


def run(file: Path, name: str, seed: int, limit: float, planner: str | None) -> Run:
    """Search for a motion and judge it."""
    begun = time.perf_counter()
    problem = load(file, limit)
    problem.check_endpoints()
    loaded = time.perf_counter() - begun
    strict = strictly(problem)
    found = search(problem, planner, seed, limit)
    made = Run(name, seed, loaded + found.setup, found.improvements, complaint=found.complaint)
    if found.trajectory is None:
        return made
    return replace(made, **vars(judge(file, problem, strict, found.trajectory)))


if __name__ == "__main__":
    environment, problem_name, number, seconds, *named = sys.argv[1:]
    chosen = named[0] if named else None
    done = run(Path(environment), problem_name, int(number), float(seconds), chosen)
    print(json.dumps(asdict(done)))
