"""A roadmap of the crane's factory: built once, then asked for motions between random places.

    python benchmarks/roadmap.py [--scenario NAME] [--build SECONDS] [--questions N] [--seed N]

Start and goal are states at rest, drawn at random and free. A pair that the roadmap does not answer
counts as a failure unless ``prm_geometric`` does not find a way either, given a minute; such a
pair is called not feasible and is replaced. Every answer is verified. Times are those of the
answers alone, from states to inputs; the verifier's own time is printed apart.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from statistics import median

import numpy as np
from gallery import describe

import kinolab
from kinolab.planners import get
from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.search.roadmap import Roadmap, RoadmapBuilder, load_roadmap, save_roadmap
from kinolab.search.roadmap.milestones import Sampler
from kinolab.simulation import Propagator
from kinolab.simulation.reference import resimulate
from kinolab.steering import Steering

NEIGHBOURS = get("prm")().neighbours  # as the planner has it
MINUTE = 60.0  # [s] that a pair is searched for, to say whether it is feasible


def main() -> int:
    """Build, ask, print; return 1 where a feasible question is not answered and verified."""
    options = arguments()
    problem = kinolab.load(options.scenario)
    explorer = RoadmapBuilder(problem, neighbours=NEIGHBOURS, seed=options.seed)
    begun, budget = time.perf_counter(), Budget(options.build)
    while not budget.over:
        explorer.grow(budget)
    built = time.perf_counter() - begun
    print(f"{describe()}\n\n{options.scenario}, seed {options.seed}\n")
    print(f"- built in {built:.1f} s: {size(explorer.roadmap)}")
    explorer = reloaded(explorer.roadmap, problem, options.seed)
    return ask(explorer, problem, options)


def size(roadmap: Roadmap) -> str:
    """Return how large a roadmap is, in words."""
    groups = np.bincount(roadmap.groups())
    whole = f"{groups.max()} of them joined both ways"
    return f"{len(roadmap.milestones)} milestones, {whole}, {len(roadmap.motions)} motions"


def reloaded(roadmap: Roadmap, problem: PlanningTask, seed: int) -> RoadmapBuilder:
    """Return a roadmap after a stay on disk."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "roadmap.npz"
        save_roadmap(path, roadmap, problem)
        begun = time.perf_counter()
        kept = load_roadmap(path, problem)
        took, kilobytes = time.perf_counter() - begun, path.stat().st_size / 1000
        print(f"- kept in a file of {kilobytes:.0f} kB, read in {took:.2f} s")
    return RoadmapBuilder(problem, neighbours=NEIGHBOURS, seed=seed, roadmap=kept)


def ask(explorer: RoadmapBuilder, problem: PlanningTask, options: argparse.Namespace) -> int:
    """Ask until enough feasible questions have been asked."""
    draw = Sampler(problem, Steering(problem), Propagator(problem), options.seed + 1000).draw
    times, proofs, verified, failed, impossible = [], [], 0, 0, 0
    while len(times) + failed < options.questions:
        start, goal = draw(), draw()
        if start is None or goal is None:
            raise SystemExit("there is no free state")
        question = between(problem, start, goal)
        begun = time.perf_counter()
        inputs = explorer.query(start, [goal], Budget(MINUTE))
        took = time.perf_counter() - begun
        if inputs is None:
            found = question.solve(planner="prm_geometric", time_limit=MINUTE, optimize=False)
            failed += found.status == "solved"
            impossible += found.status != "solved"
            continue
        times.append(took)
        begun = time.perf_counter()
        times_of_knots = problem.step * np.arange(len(inputs) + 1, dtype=float)
        motion = resimulate(question, times_of_knots, inputs)
        verified += kinolab.verify(question, motion).passed
        proofs.append(time.perf_counter() - begun)
        print(f"{len(times)}: {took:.3f} s, motion of {motion.duration:.0f} s", file=sys.stderr)
    print(f"- {len(times)} of {options.questions} feasible questions answered, {verified} verified")
    print(f"- an answer takes {median(times):.3f} s in the median, {max(times):.3f} s at most")
    print(f"- re-simulating and verifying it: {median(proofs):.1f} s in the median")
    print(f"- pairs that were not feasible: {impossible}")
    return 0 if verified == options.questions else 1


def between(problem: PlanningTask, start: np.ndarray, goal: np.ndarray) -> PlanningTask:
    """Return the problem with another start, and a goal at another state with its tolerances."""
    targets = goal[list(problem.goal.indices)]
    return replace(problem, start=start, goal=replace(problem.goal, targets=targets))


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Build a roadmap and ask it.")
    parser.add_argument("--scenario", default="crane_factory", metavar="NAME")
    parser.add_argument("--build", type=float, default=60.0, metavar="SECONDS")
    parser.add_argument("--questions", type=int, default=50, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
