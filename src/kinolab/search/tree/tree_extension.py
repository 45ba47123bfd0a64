"""Interface of tree extensions, and the search state that compiled loops work on."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.rng import State, generator
from kinolab.problem import PlanningTask
from kinolab.search.graph import SearchGraph
from kinolab.search.tree.problem_arrays import ProblemArrays, gather_problem
from kinolab.search.tree.tree import ALL_STEPS, Tree
from kinolab.simulation.collision_context import (
    CollisionContext,
    CollisionScratch,
    collision_context,
)
from kinolab.simulation.machine import Machine, machine_of

UNBOUNDED_STEPS = 2**62  # more than any motion has


class SearchState(NamedTuple):
    """Machine, problem, collision scene and random state of one search."""

    machine: Machine
    problem: ProblemArrays
    collision: CollisionContext
    scratch: CollisionScratch
    random: State


def search_state(problem: PlanningTask, goal_region_scale: float, seed: int) -> SearchState:
    """Collect the state of one search; concurrent searches share no written data."""
    return SearchState(
        machine_of(problem),
        gather_problem(problem, goal_region_scale, seed),
        *collision_context(problem),
        generator(seed),
    )


class AbstractTreeExtension(ABC):
    """A tree that grows in compiled code.

    Attributes:
        nodes: The tree.
        best: The node nearest to the goal and its normalised goal error, shape (2,).
    """

    nodes: Tree
    best: Array

    @abstractmethod
    def begin(self) -> None:
        """Clear the tree to its start."""

    @abstractmethod
    def grow(self, iterations: int) -> tuple[int, int]:
        """Grow for some iterations; return GROWING, REACHED or FULL, and the number made."""

    @property
    def steps_made(self) -> int:
        """Steps of the machine that were tried so far."""
        return int(self.nodes.rejections[ALL_STEPS])

    def explored(self) -> SearchGraph:
        """Return a copy of the tree, thinned if it is large."""
        nodes = self.nodes
        own = np.arange(nodes.x.shape[1]) != nodes.cost_entry
        parents = nodes.parent[: int(nodes.size[0])]
        return SearchGraph.of_tree(lambda kept: nodes.x[kept][:, own], parents)

    def shorten(self, steps: int) -> bool:  # noqa: ARG002
        """Search only for motions of fewer steps from now on; return whether any may exist."""
        return False

    def close(self) -> None:  # noqa: B027  most have nothing to end
        """End what grows it; there is no growth afterwards."""
