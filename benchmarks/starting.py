"""How long a compiled planner takes to its first node, and what distance grids cost.

    python benchmarks/starting.py [SCENARIO ...] [--repeats 5] [--triangles 100000]

Every start is a process of its own, with the planner's loops compiled before. A *new* machine is in
a folder without any compiled machine and without any grid; a *known* one was planned for before.
Seconds are those of the processor, so that what else runs on the computer hardly counts.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from kinolab.world import Obstacle

SCENARIOS = ("rolling_disk_maze", "crane_factory", "submarine_corridor")
PLANNER = "rrt_fast"
HEADINGS = ("scenario", "import, s", "new, s", "prepare, s", "known, s", "prepare, s")
STAGES = ("import", "node", "prepare")


def start(scenario: str) -> dict[str, float]:
    """Return how long each stage of a start takes in this process, in [s]."""
    begun = time.process_time()
    import kinolab.loading
    from kinolab.search import Budget

    imported, reached = time.process_time(), list[float]()
    restart = Budget.restart

    def noted(budget: Budget) -> None:
        reached.append(time.process_time())
        restart(budget)

    Budget.restart = noted  # type: ignore[method-assign]
    problem = kinolab.load(scenario, overrides=[f"planner.name={PLANNER}"])
    problem.check_endpoints()
    asked = time.process_time()
    problem.solve(seed=1, max_iterations=1, optimize=False)
    node, prepare = reached[0] - imported, reached[0] - asked
    return dict(zip(STAGES, (imported - begun, node, prepare), strict=True))


def started(scenario: str, folder: Path) -> dict[str, float]:
    """Return the same of a process of its own, which keeps machines and grids in a folder."""
    done = subprocess.run(
        [sys.executable, __file__, "--start", scenario],
        env={**os.environ, "KINOLAB_CACHE": str(folder)},
        capture_output=True,
        text=True,
        check=True,
    )
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


def row(scenario: str, repeats: int) -> str:
    """Return the line of a scenario."""
    new, known = [], []
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as folder:
            new.append(started(scenario, Path(folder)))
            known.append(started(scenario, Path(folder)))
    cells = [median(run["import"] for run in new + known)]
    cells += [median(run[stage] for run in runs) for runs in (new, known) for stage in STAGES[1:]]
    return f"| {scenario} | {' | '.join(f'{cell:.2f}' for cell in cells)} |"


def grid_sentence(count: int, repeats: int) -> str:
    """Say what the grid of a bumpy ball of about so many triangles costs."""
    from kinolab.world.distances.distance_field import distance_field
    from kinolab.world.distances.distance_field_cache import cached_distance_field

    builds, reads = [], []
    with tempfile.TemporaryDirectory() as folder:
        os.environ["KINOLAB_CACHE"] = folder
        cached_distance_field((bumpy_ball(count),))  # after it all is compiled, and kept
        for _ in range(repeats):
            ball = bumpy_ball(count)  # nothing of another one is known
            builds.append(_seconds(partial(distance_field, (ball,))))
            reads.append(_seconds(partial(cached_distance_field, (ball,))))
        ball = bumpy_ball(count)
        triangles = len(ball.faces)
        tracemalloc.start()
        grid = distance_field((ball,))
        peak = tracemalloc.get_traced_memory()[1] / 1e6
        tracemalloc.stop()
    return (
        f"The grid of {triangles} triangles: {grid.distance.size / 1e6:.1f} million cells, "
        f"{grid.distance.nbytes / 1e6:.0f} MB; built in {median(builds):.2f} s with {peak:.0f} MB "
        f"at most, read in {median(reads):.3f} s."
    )


def bumpy_ball(count: int) -> Obstacle:
    """Return a closed surface of about so many triangles."""
    from kinolab.world import Obstacle

    k = max(3, round(np.sqrt(count / 2)))
    u, v = np.meshgrid(2 * np.pi * np.arange(k) / k, np.linspace(0.01, np.pi - 0.01, k + 1))
    r = 3 + 0.5 * np.sin(7 * u) * np.sin(5 * v)
    points = np.stack([r * np.sin(v) * np.cos(u), r * np.sin(v) * np.sin(u), r * np.cos(v)], -1)
    i, j = np.meshgrid(np.arange(k), np.arange(k))
    a, b = j * k + i, j * k + (i + 1) % k
    faces = np.concatenate([np.stack([a, a + k, b + k], -1), np.stack([a, b + k, b], -1)])
    return Obstacle("ball", points.reshape(-1, 3), faces.reshape(-1, 3), None, False)


def _seconds(work: Callable[[], object]) -> float:
    begun = time.process_time()
    work()
    return time.process_time() - begun


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenarios", nargs="*", default=SCENARIOS)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--triangles", type=int, default=100_000)
    parser.add_argument("--start", help=argparse.SUPPRESS)
    given = parser.parse_args(arguments)
    if given.start:
        print(json.dumps(start(given.start)))
        return
    with tempfile.TemporaryDirectory() as folder:
        started(given.scenarios[0], Path(folder))  # compiles what is not
    print(f"| {' | '.join(HEADINGS)} |\n|{' --- |' * len(HEADINGS)}", flush=True)
    for scenario in given.scenarios:
        print(row(scenario, given.repeats), flush=True)
    print(f"\n{grid_sentence(given.triangles, given.repeats)}")


if __name__ == "__main__":
    main()
