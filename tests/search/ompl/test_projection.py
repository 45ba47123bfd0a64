"""The grid that planners look at: plain far from the goal, finer near it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.problem import PlanningTask
from kinolab.search.ompl.projection import CellProjection, projected_coordinates

ZOOM = 8.0


def cells(
    problem: PlanningTask,
    states: np.ndarray,
    zoom: float,
    *,
    along: int = 20,
    angles: bool = True,
) -> list[tuple[int, ...]]:
    """The cells that states lie in, each of edge 1."""
    bridge = problem.to_ompl()
    projection = CellProjection(problem, bridge.space, along, angles, zoom)
    state, found = bridge.space.allocState(), []
    for x in states:
        bridge.write(state, x.tolist())
        row = np.zeros(projection.getDimension())
        projection.project(state, row)
        found.append(tuple(np.floor(row).astype(int).tolist()))
    return found


def names(problem: PlanningTask, **wanted: Any) -> list[str]:
    return [problem.model.state_names[i] for i in projected_coordinates(problem, **wanted)]


def test_positions_come_first_and_angles_where_they_are_wanted() -> None:
    parking, cave = kinolab.load("vehicle_parking"), kinolab.load("submarine_corridor")
    assert names(parking) == ["x", "y", "psi"]
    assert names(parking, angles=False) == ["x", "y"]
    assert names(cave) == names(cave, angles=False) == ["x", "y", "z"]
    swing = kinolab.load("pendulum_swingup")
    assert names(swing, angles=False) == ["theta"]


def test_far_from_the_goal_a_cell_is_a_box_of_positions() -> None:
    problem = kinolab.load("vehicle_parking")
    states = np.random.default_rng(0).uniform(*problem.sampling_bounds.T, (300, 7))
    states = states[[problem.goal_excess(x) > ZOOM for x in states]]
    assert len(states) > 200
    for x, cell in zip(states, cells(problem, states, ZOOM, along=8, angles=False), strict=True):
        assert cell[:2] == (int(x[0] // 3.0), int(x[1] // 2.0))  # 24 m and 16 m, in eighths


def test_near_the_goal_cells_shrink_with_what_is_left() -> None:
    """Walk to the goal along x; a cell's width is what is left of the way, but for a factor."""
    problem = kinolab.load("vehicle_parking")
    goal = problem.sample_goal(np.random.default_rng(0), 1e-9)
    left = np.linspace(1.6, 0.2, 2001)  # [m]: 8 to 1 tolerances
    states = np.repeat(goal[None], len(left), axis=0)
    states[:, 0] -= left
    found = cells(problem, states, ZOOM)
    assert all(cell[0] < 0 for cell in found[1:])  # no cell of positions is one near the goal
    for cell in set(found[1:]):
        inside = left[[k for k, other in enumerate(found) if other == cell]]
        assert inside.max() - inside.min() < inside.max()
    widths = [
        np.ptp(left[[k for k, other in enumerate(found) if other == cell]])
        for cell in dict.fromkeys(found[1:])
    ]
    assert widths[-1] < widths[0] / 3


def test_near_the_goal_rates_part_cells() -> None:
    problem = kinolab.load("vehicle_parking")
    states = np.repeat(problem.sample_goal(np.random.default_rng(0), 1e-9)[None], 2, axis=0)
    states[1, -1] += 3.0  # [rad/s] of the wheels: 6 tolerances
    near, plain = (cells(problem, states, zoom) for zoom in (ZOOM, 1.0))
    assert near[0] != near[1]
    assert plain[0] == plain[1]


@pytest.mark.parametrize("name", ["crane_factory", "submarine_corridor", "pendulum_swingup"])
def test_there_are_about_a_thousand_cells_of_a_size_around_any_goal(name: str) -> None:
    """Or two per tolerance, where there are too many of these."""
    problem = kinolab.load(name)
    generator = np.random.default_rng(0)
    states = np.array([problem.sample_goal(generator, ZOOM) for _ in range(3000)])
    found = set(cells(problem, states, ZOOM))
    named = len(problem.goal.indices) + len(problem.goal.parts)
    assert 10 <= len(found) <= 4 * max(1000, 2**named)
