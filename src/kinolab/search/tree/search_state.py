"""The state of a search that compiled loops work on."""

from __future__ import annotations

from typing import NamedTuple

from kinolab.numerics.rng import State, generator
from kinolab.problem import PlanningTask
from kinolab.search.tree.problem_arrays import ProblemArrays, gather_problem
from kinolab.simulation.collision_context import (
    CollisionContext,
    CollisionScratch,
    collision_context,
)
from kinolab.simulation.machine import Machine, machine_of


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
