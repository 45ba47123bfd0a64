"""A rapidly-exploring random tree that is compiled as a whole."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from kinolab.compiled import AbstractCompiledPlanner, AbstractGrowth, Search
from kinolab.compiled.forest import add
from kinolab.compiled.question import scaled
from kinolab.compiled.rrt import grow
from kinolab.compiled.tree import begin, tree
from kinolab.problem import Problem
from kinolab.search import setting


@final
@dataclass(frozen=True, kw_only=True)
class RRTFast(AbstractCompiledPlanner):
    """Rapidly-exploring random tree, compiled: of several inputs the one that leads nearest.

    A state from which motions often came to nothing is grown from more seldom.

    Source: LaValle, Kuffner, IJRR 20(5), 2001; Cheng, LaValle, Reducing metric sensitivity in
    randomized trajectory design, IROS 2001, for what often comes to nothing.
    """

    name: ClassVar[str] = "rrt_fast"

    goal_bias: float = setting(
        0.05, 0.0, 1.0, meaning="Probability of growing toward the goal instead of anywhere."
    )

    def growth(self, problem: Problem, search: Search) -> AbstractGrowth:  # noqa: ARG002
        """Return what grows the tree."""
        return _Growth(self, search)


class _Growth(AbstractGrowth):
    def __init__(self, planner: RRTFast, search: Search) -> None:
        self._planner, self._search = planner, search
        self.nodes, self.best = tree(search.question, planner.max_nodes), np.zeros(2)

    def begin(self) -> None:
        """Leave nothing in the tree but the start."""
        question, nodes = self._search.question, self.nodes
        begin(nodes, question)
        scaled(question, question.start, nodes.point)
        add(nodes.forest, nodes.point)
        self.best[:] = 0.0, np.inf

    def grow(self, iterations: int) -> tuple[int, int]:
        """Grow by some iterations."""
        s, planner = self._search, self._planner
        ended, made = grow(
            s.machine, s.question, s.ways, s.looks, self.nodes, s.random, self.best, iterations,
            planner.goal_bias, planner.inputs_tried, planner.min_steps, planner.max_steps,
        )  # fmt: skip
        return int(ended), int(made)
