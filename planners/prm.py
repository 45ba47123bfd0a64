"""A kinodynamic probabilistic roadmap."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, final

import numpy as np
from numpy.typing import NDArray

from kinolab.errors import InputError, Mistake
from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner, Budget, Outcome, SearchResult, setting, unsolved
from kinolab.search.roadmap import RoadmapBuilder, load_roadmap, save_roadmap


@final
@dataclass(frozen=True, kw_only=True)
class PRM(AbstractPlanner):
    """Probabilistic roadmap of states at rest, joined by exact steering through the dynamics.

    Milestones are equilibria, or moving states if there are none. Every motion between them was
    simulated under the full dynamics and found collision-free. A roadmap kept in a file answers
    further queries for the same machine in the same world.

    Source: Kavraki, Svestka, Latombe, Overmars, IEEE Trans. Robotics and Automation 12(4), 1996;
    motions as edges as in Hsu, Kindel, Latombe, Rock, IJRR 21(3), 2002.
    """

    name: ClassVar[str] = "prm"
    work_per_iteration: ClassVar[float] = 3e-2

    neighbours: int = setting(8, 1, 1000, meaning="Nearest milestones that each one is steered to.")
    milestones: int = setting(
        150, 1, 1_000_000, meaning="Fewest milestones of a roadmap that is kept in a file."
    )
    roadmap: str = setting(
        "", meaning="File that keeps the roadmap, made where there is none; empty to keep none."
    )

    def solve(self, problem: PlanningTask, seed: int, budget: Budget) -> SearchResult:
        """Query the roadmap, and grow it until a query succeeds."""
        path = Path(self.roadmap) if self.roadmap else None
        if path is not None and not path.parent.is_dir():
            what = f"there is no folder {str(path.parent)!r}."
            raise InputError([Mistake("[planner] roadmap", what, "Make it, or name another file.")])
        kept = load_roadmap(path, problem) if path is not None and path.exists() else None
        builder = RoadmapBuilder(problem, neighbours=self.neighbours, seed=seed, roadmap=kept)
        budget.restart()  # code for this machine was compiled and loaded until here
        size = len(builder.roadmap.milestones)
        if path is not None:
            _grow(builder, self.milestones - size, budget)
        outcome, inputs = _query(builder, problem, budget)
        if path is not None and len(builder.roadmap.milestones) > size:
            save_roadmap(path, builder.roadmap, problem)
        statistics = {
            "milestones": float(len(builder.roadmap.milestones)),
            "motions": float(len(builder.roadmap.motions)),
        }
        times = problem.step * np.arange(len(inputs) + 1, dtype=float)
        shares = builder.rejections.shares()
        graph = builder.roadmap.graph(problem.model.nx)
        return SearchResult(outcome, times, inputs, budget.iterations, statistics, shares, graph)


def _grow(builder: RoadmapBuilder, count: int, budget: Budget) -> bool:
    """Add up to ``count`` milestones; False if none could be added."""
    added = 0
    while added < count and not budget.over and builder.grow(budget) is not None:
        added += 1
    return added > 0


def _query(
    builder: RoadmapBuilder, problem: PlanningTask, budget: Budget
) -> tuple[Outcome, NDArray[np.float64]]:
    """Query after every batch of milestones until one succeeds or time runs out."""
    if problem.goal_excess(problem.start) <= 1.0:
        return Outcome.SOLVED, np.zeros((0, problem.model.nu))
    goals, batch = builder.goals(5, budget), 1  # goal states per query
    while goals and not budget.over:
        inputs = builder.query(problem.start, goals, budget)
        if inputs is not None:
            return Outcome.SOLVED, inputs
        if not _grow(builder, batch, budget):
            break
        batch = min(2 * batch, 10)  # milestones between queries; the first queries come sooner
    inputs = builder.approach(problem.start, problem.goal_distance)
    return unsolved(budget, len(inputs)), inputs
