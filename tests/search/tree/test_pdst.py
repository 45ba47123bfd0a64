"""PDST: cells that make up the whole, motions that lie in them, the next one on top."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab import planners
from kinolab.problem import PlanningTask
from kinolab.problem.metric import projected_coordinates
from kinolab.search.tree import search_state
from kinolab.search.tree.pdst.subdivision import CELLS, LEAF, MOTIONS, ROUNDS

SCENES = ("rolling_disk_maze", "pendulum_swingup")


@pytest.fixture(scope="module", params=SCENES)
def grown(request: pytest.FixtureRequest) -> tuple[PlanningTask, Any, Any]:
    """A problem, its tree after some hundred rounds, and the cells."""
    problem = kinolab.load(request.param)
    growth = planners.get("pdst")().extension(problem, search_state(problem, 10.0, 3))
    growth.begin()
    growth.grow(700)
    return problem, growth.nodes, growth._cells.held


def leaves(cells: Any) -> list[int]:
    return [cell for cell in range(cells.counts[CELLS]) if cells.axis[cell] == LEAF]


def projected(problem: PlanningTask, x: np.ndarray) -> np.ndarray:
    """Return what is divided of states (m, nx), angles within one turn, (m, k)."""
    entries = projected_coordinates(problem)
    low, high = problem.sampling_bounds[entries].T
    found = x[:, entries]
    around = problem.circular[entries]
    return np.where(around, low + (found - low) % (high - low), found)


def states_of(problem: PlanningTask, tree: Any, motion: int) -> np.ndarray:
    """Return the states after each step of a motion, as the model makes them."""
    x, found = tree.x[tree.parent[motion]], []
    for _ in range(tree.steps[motion]):
        method = problem.scenario.integration.method
        x = problem.model.step(x, tree.u[motion], problem.step, method=method)
        found.append(x)
    return np.array(found)


def test_cells_make_up_the_whole(grown: Any) -> None:
    problem, _, cells = grown
    own = leaves(cells)
    assert len(own) == cells.counts[ROUNDS] + 1  # each round halves one
    assert sum(0.5 ** float(cells.divisions[cell]) for cell in own) == pytest.approx(1.0, abs=1e-12)
    spans = np.diff(problem.sampling_bounds[projected_coordinates(problem)].T, axis=0)[0]
    volumes = [np.prod((cells.upper[c] - cells.lower[c]) / spans) for c in own]
    assert volumes == pytest.approx([0.5 ** float(cells.divisions[c]) for c in own], rel=1e-9)


def test_every_motion_lies_in_its_cell(grown: Any) -> None:
    problem, tree, cells = grown
    size = int(tree.size[0])
    assert size > 700
    for motion in np.random.default_rng(0).integers(1, size, 200):
        way = projected(problem, states_of(problem, tree, motion))
        cell = cells.cell[motion]
        outside = np.maximum(cells.lower[cell] - way, way - cells.upper[cell])
        low, high = problem.sampling_bounds[projected_coordinates(problem)].T
        inside_all = ((way >= low) & (way <= high)).all(axis=1)  # others lie in cells at the rim
        assert (outside[inside_all] <= 1e-12).all()


def test_each_motion_is_in_one_list_and_once_in_the_heap(grown: Any) -> None:
    _, tree, cells = grown
    size, listed = int(tree.size[0]), []
    for cell in leaves(cells):
        motion = cells.first[cell]
        while motion >= 0:
            assert cells.cell[motion] == cell
            listed.append(int(motion))
            motion = cells.following[motion]
    assert sorted(listed) == list(range(size))
    assert sorted(cells.heap[: cells.counts[MOTIONS]].tolist()) == list(range(size))


def test_the_motion_on_top_has_the_least_score(grown: Any) -> None:
    _, tree, cells = grown
    own = cells.cell[: int(tree.size[0])]
    scores = cells.priority[: len(own)] * 2.0 ** cells.divisions[own]
    assert scores[cells.heap[0]] == scores.min()
