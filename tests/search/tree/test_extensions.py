"""Extensions in lanes: what they lead to depends neither on lanes nor on slices of time."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from kinolab import planners
from kinolab.problem import PlanningTask
from kinolab.search.tree import search_state
from kinolab.search.tree.tree import FULL, GROWING
from tests.trees import contents, same

IN_LANES = ("rrt_fast", "sst", "ao_rrt")
BOUND = 4000  # steps: of motions into the goal that are looked for


def growth_of(problem: PlanningTask, name: str, *, lanes: bool = True, **settings: Any) -> Any:
    planner = planners.make(name, settings)
    search = search_state(problem, 1.0, 1)
    if not lanes:
        search = search._replace(machine=search.machine._replace(step_in_lanes=0, f_in_lanes=0))
    growth = planner.extension(problem, search)  # type: ignore[attr-defined]
    growth.begin()
    if name != "rrt_fast":
        growth.shorten(BOUND)  # below a bound ao_rrt and sst have loops of their own
    return growth


@pytest.mark.parametrize("name", IN_LANES)
def test_slices_of_time_do_not_show(name: str, maze: PlanningTask) -> None:
    whole, pieces = growth_of(maze, name), growth_of(maze, name)
    made = whole.grow(3000)[1]
    so_far, random = 0, np.random.default_rng(2)
    while so_far < made:
        ended, more = pieces.grow(min(int(random.integers(1, 60)), made - so_far))
        assert ended == GROWING
        so_far += more
    assert so_far == made
    assert int(whole.nodes.size[0]) > 200
    assert same(contents(whole), contents(pieces))


@pytest.mark.parametrize("name", IN_LANES)
def test_lanes_do_not_show(name: str, maze: PlanningTask) -> None:
    """A machine without code for lanes makes the same steps one by one."""
    some, single = growth_of(maze, name), growth_of(maze, name, lanes=False)
    some.grow(2000)
    single.grow(2000)
    assert same(contents(some), contents(single))


@pytest.mark.parametrize("name", IN_LANES)
def test_what_is_under_way_is_dropped_with_its_tree(name: str, maze: PlanningTask) -> None:
    growth = growth_of(maze, name, max_nodes=64)
    while growth.grow(10)[0] != FULL:
        pass
    assert (growth.nodes.extensions.parent >= 0).any()
    growth.begin()
    assert (growth.nodes.extensions.parent < 0).all()
    assert int(growth.nodes.size[0]) == 1


def test_a_sparse_tree_that_is_swept_keeps_what_is_being_extended(maze: PlanningTask) -> None:
    growth = growth_of(maze, "sst", max_nodes=300)
    for _ in range(400):
        growth.grow(20)
        lanes = growth.nodes.extensions
        size = int(growth.nodes.size[0])
        assert (lanes.parent < size).all()
        for lane in np.flatnonzero((lanes.parent >= 0) & (lanes.made == 0) & (lanes.ended == 0)):
            assert np.array_equal(lanes.now[:, lane], growth.nodes.x[lanes.parent[lane]])
