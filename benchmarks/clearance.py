"""The room that compiled planners reckon with, against FCL: random poses, and motions looked at
every 0.1 mm.

    python benchmarks/clearance.py [NAME ...] [--poses 20000] [--motions 300] [--json FILE]

Prints a Markdown table. A pose is accepted where its room is more than nothing; one that FCL calls
in collision is *wrongly accepted*. One that is refused although FCL finds more room than the margin
that is kept is *wrongly refused*. The motions are drawn from a tree that `rrt_fast` grew: the way
of each is followed by the planner's own steps, so closely that no point of the machine moves
further than 0.1 mm between two looks, and FCL looks at every one of them.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from gallery import describe
from numpy.typing import NDArray

import kinolab
from kinolab import planners
from kinolab.problem import PlanningTask
from kinolab.scenario import builtin_scenarios
from kinolab.search.tree import AbstractCompiledPlanner, search_state
from kinolab.world.collision.clearance_bound import ClearanceBound
from kinolab.world.collision.collision_scene import collision_scene
from kinolab.world.distances.triangle_gaps import TOUCHING_MARGIN

SPACING = 1e-4  # [m] between two looks at a motion
ITERATIONS = 5000  # of the tree
HEADINGS = (
    *("scenario", "poses", "refused", "wrongly accepted", "wrongly refused"),
    *("motions", "looks", "collisions"),
)


@dataclass(frozen=True)
class Counts:
    """What was found in one scenario.

    Attributes:
        scenario: Its name.
        poses: Drawn at random.
        refused: Of these.
        wrongly_accepted: Poses that FCL calls in collision.
        wrongly_refused: Poses with more room than is kept.
        motions: Of a tree.
        looks: At these.
        collisions: At how many of them FCL finds one.
    """

    scenario: str
    poses: int
    refused: int
    wrongly_accepted: int
    wrongly_refused: int
    motions: int
    looks: int
    collisions: int


def count(name: str, poses: int, motions: int) -> Counts:
    """Look at random poses and at motions of one scenario."""
    problem = kinolab.load(name)
    refused, accepted_wrongly, refused_wrongly = judge_poses(problem, poses)
    looks, collisions = judge_motions(problem, motions)
    return Counts(
        name, poses, refused, accepted_wrongly, refused_wrongly, motions, looks, collisions
    )


def judge_poses(problem: PlanningTask, poses: int) -> tuple[int, int, int]:
    """Return how many poses are refused, wrongly accepted and wrongly refused."""
    around = collision_scene(
        problem.bodies, problem.world, cables=problem.cables, self_pairs=problem.system.collisions
    )
    room, checker = ClearanceBound(around), problem.checker()
    refused = accepted_wrongly = refused_wrongly = 0
    for x in states(problem, poses):
        placed = problem.placement(x)
        free, touches = room.within(*placed, 1e-9) > 0.0, checker.collides(*placed)
        accepted_wrongly += free and touches
        refused += not free
        if not (free or touches):
            refused_wrongly += checker.clearance(*placed) > 1.5 * TOUCHING_MARGIN
    return refused, accepted_wrongly, refused_wrongly


def states(problem: PlanningTask, number: int) -> NDArray[np.float64]:
    """Draw states within their limits, all alike."""
    random = np.random.default_rng(1)
    x = random.uniform(*problem.sampling_bounds.T, (number, problem.model.nx))
    for first in problem.model.attitudes.values():
        q = random.normal(size=(number, 4))
        x[:, first : first + 4] = q / np.linalg.norm(q, axis=1, keepdims=True)
    return x


def judge_motions(problem: PlanningTask, motions: int) -> tuple[int, int]:
    """Return how many looks were made at motions of a tree, and at how many of them FCL objects."""
    planner = planners.get("rrt_fast")()
    assert isinstance(planner, AbstractCompiledPlanner)
    growth = planner.extension(problem, search_state(problem, planner.goal_region_scale, 1))
    growth.begin()
    growth.grow(ITERATIONS)
    tree, checker = growth.nodes, problem.checker()
    looks = collisions = 0
    for node in np.random.default_rng(2).integers(1, int(tree.size[0]), motions):
        for x in way(problem, tree.x[tree.parent[node]], tree.u[node], int(tree.steps[node])):
            looks += 1
            collisions += checker.collides(*problem.placement(x))
    return looks, collisions


def way(
    problem: PlanningTask, x: NDArray[np.float64], u: NDArray[np.float64], steps: int
) -> Iterator[NDArray[np.float64]]:
    """Yield states so close to each other that no point moves further than SPACING in between."""
    model, settings = problem.model, problem.scenario.integration
    how = {"method": settings.method, "substeps": settings.substeps}
    for _ in range(steps):
        after = model.step(x, u, problem.step, **how)
        fastest = max(speed(problem, state, u) for state in (x, after))
        pieces = max(1, math.ceil(1.2 * fastest * problem.step / SPACING))
        for k in range(1, pieces + 1):
            yield model.step(x, u, problem.step * k / pieces, **how)
        x = after


def speed(problem: PlanningTask, x: NDArray[np.float64], u: NDArray[np.float64]) -> float:
    """Return the speed of the fastest point of the machine, in [m/s]."""
    model = problem.model
    speeds = [*model.point_speed(x, u), *(model.cable_speed(x, u) if problem.cables else ())]
    return float(max(speeds))


def table(counts: Sequence[Counts]) -> str:
    """Return what was found as a Markdown table."""
    rows = [HEADINGS, ("---",) * len(HEADINGS)]
    rows += [tuple(str(value) for value in asdict(entry).values()) for entry in counts]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def main() -> None:
    """Print the table."""
    known = builtin_scenarios()
    parser = argparse.ArgumentParser(description="Judge the room of machines against FCL.")
    parser.add_argument("names", nargs="*", metavar="NAME", help="scenarios; default: all")
    parser.add_argument("--poses", type=int, default=20_000, metavar="N")
    parser.add_argument("--motions", type=int, default=300, metavar="N")
    parser.add_argument("--json", metavar="FILE", help="write the counts to a file")
    options = parser.parse_args()
    if unknown := set(options.names) - set(known):
        parser.error(f"no scenario is called {', '.join(sorted(unknown))}")
    found = [count(name, options.poses, options.motions) for name in options.names or known]
    print(f"{describe()}\n\n{table(found)}")
    if options.json:
        Path(options.json).write_text(json.dumps([asdict(entry) for entry in found], indent=1))


if __name__ == "__main__":
    main()
