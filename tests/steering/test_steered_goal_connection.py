"""The last step into the goal, against the coin's motion in closed form."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.dynamics import Body, Force, Potential, Sphere, System, length, move
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.problem import PlanningTask
from kinolab.steering.goal_connection import SteeredGoalConnection
from tests.support import OPEN, coin_after, problem_of

GUIDED = ("est", "kpiece", "syclop_est", "syclop_rrt")


@pytest.fixture(scope="module")
def narrow(tmp_path_factory: pytest.TempPathFactory) -> PlanningTask:
    """The coin is to stand still within a millimetre: no sampled input does that."""
    folder = tmp_path_factory.mktemp("narrow")
    return problem_of(folder, OPEN, "goal.tolerance=0.001", "goal.at_rest=true")


def never() -> bool:
    return False


def rolled(x: np.ndarray, inputs: np.ndarray, step: float) -> np.ndarray:
    for u in inputs:
        x = coin_after(x, u, np.array([step]))[0]
    return x


def test_the_inputs_lead_from_the_state_into_the_goal(narrow: PlanningTask) -> None:
    last = SteeredGoalConnection(narrow, every=1, goal_region_scale=10.0, stop=never)
    x = narrow.start.copy()
    x[-2:] = 0.5, 1.0  # it turns and rolls
    assert last.connect(x.tolist(), narrow.goal_excess(x))
    reached = rolled(x, np.array(last.inputs), narrow.step)
    assert np.abs(reached[:2]).max() < 1.1e-3
    assert np.abs(reached[-2:]).max() < 1e-2


def test_one_state_of_several_is_tried(narrow: PlanningTask) -> None:
    last, x = (
        SteeredGoalConnection(narrow, every=3, goal_region_scale=10.0, stop=never),
        narrow.start.tolist(),
    )
    assert [last.connect(x, 1000.0) for _ in range(6)] == [False, False, True] * 2
    assert last.inputs
    assert last.statistics["goal_connections"] == 2.0
    # at least the motions that were found, each twice: as they were computed, and for collisions
    assert last.statistics["goal_connection_propagations"] >= 4 * len(last.inputs)
    assert not last.connect(x, 1000.0)
    assert last.inputs == []  # none that belong to a state before


def test_a_state_in_the_goal_needs_no_last_step(narrow: PlanningTask) -> None:
    last = SteeredGoalConnection(narrow, every=1, goal_region_scale=10.0, stop=never)
    assert last.connect(narrow.start.tolist(), 1000.0)
    assert not last.connect(np.zeros(6).tolist(), 0.0)
    assert last.inputs == []


def test_machines_that_are_not_flat_are_steered_near_the_goal_alone() -> None:
    board = kinolab.load("snakeboard_park")
    last, generator = (
        SteeredGoalConnection(board, every=1, goal_region_scale=10.0, stop=never),
        np.random.default_rng(0),
    )
    starts = [board.sample_goal(generator, 1.5) for _ in range(20)]
    outside = [x for x in starts if board.goal_excess(x) > 1.0]
    reached = [x for x in outside if last.connect(x.tolist(), board.goal_excess(x))]
    assert reached
    assert not last.connect(reached[0].tolist(), 10.1)


RUNAWAY = """
schema = 1
title = "A mass that is pushed away at 100/s"
system.file = "machine.json"
world.bounds = { x = [-1, 1] }
goal.x = 0.0
integration.step = 0.05
"""


@pytest.mark.filterwarnings("error")
def test_a_machine_that_runs_away_is_not_steered_and_no_mistake(tmp_path: Path) -> None:
    """After 160 steps it is 1e290 m away: finite, but its square is not."""
    x = length("x", speed=1.0)
    mass = Body("mass", move(x), mass=1.0, shape=Sphere(0.1))
    force = Force("push", on=mass, along=move().x, limit=1.0)
    away = System("away", bodies=[mass], efforts=[Potential(-5000 * x**2)], inputs=[force])
    (tmp_path / "machine.json").write_text(machine_to_json(away))
    problem = problem_of(tmp_path, RUNAWAY)
    last = SteeredGoalConnection(problem, every=1, goal_region_scale=10.0, stop=never)
    assert not last.connect([0.5, 0.0], problem.goal_excess(np.array([0.5, 0.0])))


def test_nothing_is_looked_for_when_time_is_up(narrow: PlanningTask) -> None:
    last = SteeredGoalConnection(narrow, every=1, goal_region_scale=10.0, stop=lambda: True)
    assert not last.connect(narrow.start.tolist(), 1000.0)


@pytest.mark.parametrize("planner", GUIDED)
def test_a_plan_goes_on_from_the_tree_into_the_goal(planner: str, narrow: PlanningTask) -> None:
    """Within 20 iterations, where 300 without a last step are not enough."""
    found = narrow.solve(planner=planner, seed=1, max_iterations=300, goal_connection_period=5)
    assert found.status == "solved"
    assert found.trajectory is not None
    reached = rolled(narrow.start, found.trajectory.u, narrow.step)
    assert np.abs(reached[:2]).max() < 1.1e-3
    sampled = narrow.solve(planner=planner, seed=1, max_iterations=300, goal_connection_period=0)
    assert sampled.status != "solved"
