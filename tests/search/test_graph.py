"""What a search explored: kept, thinned, written, and read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.errors import InputError
from kinolab.problem import PlanningTask
from kinolab.runs import read_run, write_run
from kinolab.search.graph import SearchGraph, read_graph


@pytest.fixture(scope="module")
def problem() -> PlanningTask:
    return kinolab.load("rolling_disk_maze")


@pytest.mark.parametrize("planner", ["rrt_fast", "rrt", "prm"])
def test_all_that_was_explored_is_free_and_hangs_together(
    problem: PlanningTask, planner: str
) -> None:
    plan = problem.solve(planner=planner, seed=1, time_limit=30.0, optimize=False)
    assert plan.graph is not None
    x, edges = plan.graph.x, plan.graph.edges
    assert len(x) > 10
    assert not problem.outside_limits(x).any()
    checker = problem.checker()
    assert not any(checker.collides(*problem.placement(state)) for state in x[:: len(x) // 10])
    if planner != "prm":
        (root,) = np.setdiff1d(np.arange(len(x)), edges[:, 1])
        assert np.allclose(x[root], problem.start, rtol=0, atol=1e-12)
        assert len(edges) == len(x) - 1  # a tree


def test_a_thinned_tree_joins_states_to_the_nearest_ancestors_that_are_left() -> None:
    rng = np.random.default_rng(1)
    parents = np.array([-1, *(rng.integers(0, k) for k in range(1, 5000))])
    x = np.arange(5000.0)[:, None]
    thin = SearchGraph.of_tree(lambda rows: x[rows], parents, most=100)
    assert len(thin.x) == 100
    left = set(thin.x[:, 0].astype(int).tolist())
    for above, below in thin.x[thin.edges, 0].astype(int):
        ancestor = parents[below]
        while ancestor not in left:
            ancestor = parents[ancestor]
        assert ancestor == above
    assert len(thin.edges) == 99


def test_a_small_tree_is_kept_as_it_is_and_every_root_is_kept() -> None:
    x, parents = np.eye(7), np.array([1, 2, -1, 2, 0, -1, 5])
    whole = SearchGraph.of_tree(lambda rows: x[rows], parents)
    assert np.array_equal(whole.x, x)
    assert sorted(map(tuple, whole.edges.tolist())) == [(0, 4), (1, 0), (2, 1), (2, 3), (5, 6)]
    roots = SearchGraph.of_tree(lambda rows: x[rows], parents, most=1).x
    assert np.array_equal(roots, x[[0, 2, 5]])


def test_a_run_keeps_its_graph_until_another_plan_has_none(
    problem: PlanningTask, tmp_path: Path
) -> None:
    plan = problem.solve(planner="rrt_fast", seed=1, max_iterations=50, optimize=False)
    assert plan.graph is not None
    write_run(tmp_path, problem, plan)
    run = read_run(tmp_path)
    assert run.graph is not None
    assert np.array_equal(run.graph.x, plan.graph.x)
    assert np.array_equal(run.graph.edges, plan.graph.edges)
    names = problem.model.state_names
    with pytest.raises(InputError, match="not of this machine"):
        read_graph(tmp_path / "search.npz", names[1:])
    (tmp_path / "search.npz").write_bytes(b"PK nothing of the kind")
    with pytest.raises(InputError, match="damaged"):
        read_graph(tmp_path / "search.npz", names)
    field = problem.solve(planner="potential_field", max_iterations=200, optimize=False)
    write_run(tmp_path, problem, field)
    assert read_run(tmp_path).graph is None
