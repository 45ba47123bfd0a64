"""Two trees in flat outputs, joined by polynomials, and shortcuts between their states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner, Budget, Outcome, SearchResult, setting, unsolved
from kinolab.search.flat.flat_search import FlatConnection
from kinolab.search.flat.flat_trees import FILLED, LINKED
from kinolab.search.rejection_sources import rejection_sources

NO_PLACE = (
    "flat_connect comes to rest in the goal, where it found no free place to rest; "
    "auto also plans for goals that are passed at speed."
)
BATCH = 50  # shortcuts after which a motion is followed


@final
@dataclass(frozen=True, kw_only=True)
class FlatConnect(AbstractPlanner):
    """Two trees of rest-to-rest lines in flat outputs, joined and shortened by polynomials.

    For machines whose inputs accelerate all that can move: arms, points and platforms, and wheels
    that turn on the spot; and for cars, whose trees are of the curves of Reeds, Shepp and Dubins,
    along which they steer while they drive. Nothing is integrated before a way is found, which
    takes milliseconds. Each further tree looks for another way round the obstacles. Where a motion
    is improved anyway, the first one is returned after a few shortcuts.

    Source: Kuffner, LaValle, RRT-Connect, ICRA 2000; Hauser, Ng-Thow-Hing, Fast smoothing of
    manipulator trajectories using optimal bounded-acceleration shortcuts, ICRA 2010; Duong, Ramsey,
    Kingston, Thomason, Kavraki, FLASK, arXiv 2603.16059, 2026.
    """

    name: ClassVar[str] = "flat_connect"
    work_per_iteration: ClassVar[float] = 2e-5

    reach: float = setting(
        0.2, 1e-3, 1.0, unit="diagonals", meaning="Longest extension of a tree, of the whole space."
    )
    shortcuts: int = setting(
        400, 0, 1_000_000, meaning="Shortcuts that are tried of each motion that the trees find."
    )
    rounds: int = setting(
        1, 1, 100_000, meaning="Motions that are found, each by new trees; the shortest is kept."
    )
    max_nodes: int = setting(
        20_000, 128, 20_000_000, unit="nodes", meaning="Most states of a tree; then it begins anew."
    )

    def solve(self, problem: PlanningTask, seed: int, budget: Budget) -> SearchResult:
        """Grow trees until they meet, shorten what they found, and do it again.

        Raises:
            InputError: If the machine is none that can be planned for in flat outputs.
        """
        search, found, restarts = FlatConnection(problem, seed, self.reach, self.max_nodes), 0, 0
        search.prepare()
        budget.restart()  # code was compiled and loaded until here
        rounds = 1 if budget.improve == 0.0 else self.rounds
        while search.has_goals and found < rounds and not budget.over:
            # iterations of the trees between two looks at the clock
            ended, made = search.grow(int(min(200, budget.left)))
            budget.spend(made)
            if ended == LINKED and search.connect():
                found += self._shorten(search, budget)
            if ended in (LINKED, FILLED):
                restarts += 1
                search.begin()
        u = search.u
        outcome = Outcome.SOLVED
        rejections: Mapping[str, Mapping[str, float]] = {}
        if u is None:
            u = search.approach()
            outcome = unsolved(budget, len(u))
            if not budget.interrupted:
                # steps for which inputs are held, where it is told what was in the way
                rejections = rejection_sources(problem, search.states, 20, budget)
        times = problem.step * np.arange(len(u) + 1.0)
        statistics = {"restarts": float(restarts), "nodes": float(search.nodes)}
        warnings = () if search.has_goals else (NO_PLACE,)
        return SearchResult(
            outcome, times, u, budget.iterations, statistics, rejections, search.graph, warnings
        )

    def _shorten(self, search: FlatConnection, budget: Budget) -> bool:
        """Try shortcuts of the motion that was found last; say whether it leads into the goal."""
        left, leads = min(self.shortcuts, BATCH if budget.improve == 0.0 else self.shortcuts), False
        while left > 0 and not budget.over:
            tried = int(min(BATCH, left, budget.left))
            leads = search.shorten(tried) or leads
            budget.spend(tried)
            left -= tried
        return leads or search.shorten(0)
