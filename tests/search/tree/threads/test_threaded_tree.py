"""A tree that several threads grow: what comes of it depends on their number alone."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab import planners
from kinolab.numerics.jit import kernel
from kinolab.problem import PlanningTask
from kinolab.search.tree import search_state
from kinolab.search.tree.threads import threaded_tree
from kinolab.search.tree.threads.atomics import atomic_add, compare_and_swap
from kinolab.search.tree.tree import FULL, GROWING
from tests.support import OPEN, problem_of
from tests.trees import contents, same

THREADED = ("rrt_fast", "sst")
BOUND = 4000  # steps of motions that a sparse tree looks for
LOOKS = 5  # per step


def growth_of(problem: PlanningTask, name: str, threads: int = 2, **settings: Any) -> Any:
    planner = planners.make(name, settings | {"threads": threads})
    growth = planner.extension(problem, search_state(problem, 1.0, 1))  # type: ignore[attr-defined]
    growth.begin()
    growth.grow(0)
    return growth


@pytest.mark.parametrize("name", THREADED)
def test_processors_do_not_show(
    name: str, maze: PlanningTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One thread that does all parts, and more threads than most computers of tests have."""
    found = []
    for count in (1, 4):
        monkeypatch.setattr(threaded_tree, "processors", lambda count=count: count)
        growth = growth_of(maze, name, threads=4)
        for _ in range(10):
            assert growth.grow(1000)[0] == GROWING
        growth.close()
        found.append(contents(growth))
    assert len(found[0][0]) > 500
    assert same(*found)


@pytest.mark.parametrize("name", THREADED)
def test_slices_of_time_do_not_show(name: str, maze: PlanningTask) -> None:
    whole, pieces = growth_of(maze, name), growth_of(maze, name)
    made = whole.grow(3000)[1]
    assert made >= 3000
    so_far, random = 0, np.random.default_rng(2)
    while so_far < made:
        ended, more = pieces.grow(min(int(random.integers(1, 200)), made - so_far))
        assert ended == GROWING
        so_far += more
    assert so_far == made
    assert same(contents(whole), contents(pieces))
    whole.close()
    pieces.close()


@pytest.mark.parametrize("scene", ["rolling_disk_maze", "two_cranes"])
@pytest.mark.parametrize("name", THREADED)
def test_every_motion_is_free_and_leads_where_it_says(name: str, scene: str) -> None:
    problem = kinolab.load(scene)
    growth, model, checker = growth_of(problem, name), problem.model, problem.checker()
    growth.grow(2000)
    growth.close()
    tree, random = growth.nodes, np.random.default_rng(0)
    method = problem.scenario.integration.method
    for node in random.integers(1, int(tree.size[0]), 100):
        x, u, parent = tree.x[tree.parent[node]], tree.u[node], tree.parent[node]
        assert tree.cost[node] == tree.cost[parent] + tree.steps[node]
        for _ in range(tree.steps[node]):
            share = random.uniform(0, problem.step, LOOKS)
            between = model.step(np.tile(x, (LOOKS, 1)), u, share, method=method)
            poses, ends = problem.placement(between)
            assert checker.first_collision(poses, ends if problem.cables else None) is None
            x = model.step(x, u, problem.step, method=method)
            assert not list(problem.limit_violations(x))
        np.testing.assert_allclose(x, tree.x[node], rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", THREADED)
def test_no_two_workers_draw_the_same(name: str, maze: PlanningTask) -> None:
    growth = growth_of(maze, name)
    growth.grow(2000)
    growth.close()
    drawn = growth.nodes.u[1 : int(growth.nodes.size[0])]
    assert len(np.unique(drawn, axis=0)) == len(drawn) > 100


def test_a_full_tree_says_so_and_begins_anew(maze: PlanningTask) -> None:
    growth = growth_of(maze, "rrt_fast", max_nodes=64)
    while growth.grow(10)[0] != FULL:
        pass
    assert int(growth.nodes.size[0]) == 64
    growth.begin()
    assert int(growth.nodes.size[0]) == 1
    assert growth.grow(1)[0] == GROWING
    assert (growth.nodes.parent[1 : int(growth.nodes.size[0])] == 0).all()  # none from before
    growth.close()


def test_a_sparse_tree_is_swept_and_goes_on(maze: PlanningTask) -> None:
    radii = {"selection_radius": 1.0, "pruning_radius": 0.4, "improving_radius": 1.0}
    growth = growth_of(maze, "sst", max_nodes=250, **radii)
    growth.shorten(BOUND)
    swept = 0
    for _ in range(40):
        before = int(growth.nodes.size[0])
        if growth.grow(100)[0] == FULL:
            break
        tree, size = growth.nodes, int(growth.nodes.size[0])
        swept += size < before
        assert (tree.parent[1:size] < np.arange(1, size)).all()
        parents = tree.parent[1:size]
        np.testing.assert_array_equal(tree.cost[1:size], tree.cost[parents] + tree.steps[1:size])
    assert swept
    growth.close()


def test_a_sparse_tree_keeps_its_bound(maze: PlanningTask) -> None:
    growth = growth_of(maze, "sst")
    growth.grow(3000)
    tree = growth.nodes
    most = int(np.median(tree.cost[: int(tree.size[0])]))
    assert growth.shorten(most)
    growth.grow(3000)
    held = growth._first.held.witnesses
    assert held.cost[: int(held.neighbours.counts[0])].max() + 1 < most
    growth.close()


@pytest.mark.parametrize("name", THREADED)
def test_a_plan_passes_the_check_and_no_thread_is_left(name: str, tmp_path: Path) -> None:
    problem, threads = problem_of(tmp_path, OPEN), threading.active_count()
    found = problem.solve(planner=name, seed=1, max_iterations=20_000, threads=2)
    assert found.status == "solved"
    assert found.certificate is not None
    assert found.certificate.passed
    assert threading.active_count() == threads


def test_a_system_without_a_thread_left_grows_the_same_tree(
    maze: PlanningTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: Any) -> None:
        raise RuntimeError("can't start new thread")

    beside = growth_of(maze, "rrt_fast")
    beside.grow(1000)
    monkeypatch.setattr(ThreadPoolExecutor, "submit", refuse)
    alone = growth_of(maze, "rrt_fast")
    alone.grow(1000)
    assert same(contents(beside), contents(alone))
    beside.close()
    alone.close()


@kernel
def count_up(words, times):  # type: ignore[no-untyped-def]
    for _ in range(times):
        atomic_add(words, 0, 1)
        while not compare_and_swap(words, 8, words[8], words[8] + 1):
            pass


def test_nothing_that_threads_count_at_once_is_lost() -> None:
    words, times = np.zeros(16, np.int64), 200_000
    count_up(words, 0)
    with ThreadPoolExecutor(4) as pool:
        for one in [pool.submit(count_up, words, times) for _ in range(4)]:
            one.result()
    assert words[0] == words[8] == 4 * times
