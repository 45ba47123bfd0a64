"""Makes the plan of a finished run exact and shorter: ``python gallery_optimised.py DIR SECONDS``.

It prints the duration and the goal distance of what came out as JSON, or fails where that does not
pass the verifier.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import kinolab
from kinolab.runs import read_run
from kinolab.trajopt import make_exact, shorten


def main(folder: str, seconds: str) -> int:
    """Take so much time of this thread; return 1 where the optimiser gives nothing that is true."""
    run, end = read_run(Path(folder)), time.thread_time() + float(seconds)
    exact = make_exact(run.problem, run.trajectory, lambda: time.thread_time() > end)
    if exact is None:
        print("the plan could not be made exact", file=sys.stderr)
        return 1
    made = shorten(run.problem, exact, end - time.thread_time())
    certificate = kinolab.verify(run.problem, made)
    if not certificate.passed:
        print("\n".join(map(str, certificate.failures)), file=sys.stderr)
        return 1
    miss = run.problem.goal_distance(made.x[-1])
    print(json.dumps({"optimised": made.duration, "goal_distance": miss}))
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
