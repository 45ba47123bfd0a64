"""Trees that compiled loops grow: every motion in them is free, and leads where it says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab import planners
from kinolab.planners import auto
from kinolab.problem import PlanningTask
from kinolab.search import Budget, Outcome
from kinolab.search.tree import AbstractCompiledPlanner, search_state
from kinolab.simulation.resimulated_goal import TrueEnds
from tests.support import OPEN, problem_of

COMPILED = ("auto", "rrt_fast", "kpiece_fast", "sst", "ao_rrt", "pdst")
SCENES = ("rolling_disk_maze", "vehicle_parking", "two_cranes")
MOTIONS = 100  # of a tree that are looked at
LOOKS = 20  # per step


def grown(name: str, problem: PlanningTask, iterations: int) -> Any:
    settings = planners.get(name)()
    assert isinstance(settings, AbstractCompiledPlanner)
    growth = settings.extension(problem, search_state(problem, settings.goal_region_scale, 1))
    growth.begin()
    growth.grow(iterations)
    return growth.nodes


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("name", COMPILED)
def test_no_motion_of_a_tree_touches_anything_on_its_way(name: str, scene: str) -> None:
    problem = kinolab.load(scene)
    tree, model = grown(name, problem, 2000), problem.model
    size, checker = int(tree.size[0]), problem.checker()
    assert size > 20
    random = np.random.default_rng(0)
    method = problem.scenario.integration.method
    for node in random.integers(1, size, MOTIONS):
        x, u = tree.x[tree.parent[node]], tree.u[node]
        for _ in range(tree.steps[node]):
            share = random.uniform(0, problem.step, LOOKS)
            between = model.step(np.tile(x, (LOOKS, 1)), u, share, method=method)
            poses, ends = problem.placement(between)
            assert checker.first_collision(poses, ends if problem.cables else None) is None
            x = model.step(x, u, problem.step, method=method)
            assert not list(problem.limit_violations(x))
        np.testing.assert_allclose(x, tree.x[node], rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", COMPILED)
def test_a_full_tree_makes_room_for_a_new_one(name: str, table: PlanningTask) -> None:
    found = (
        table.solve(planner=name, seed=1, max_iterations=3000, max_nodes=64, goal_bias=0.0)
        if name == "rrt_fast"
        else table.solve(planner=name, seed=1, max_iterations=3000, max_nodes=64)
    )
    assert found.statistics["nodes"] <= 64


@pytest.mark.parametrize("name", COMPILED)
def test_axes_keep_out_of_cones(name: str, tmp_path: Path) -> None:
    cone = (
        '[[keep_out]]\nbody = "coin"\naxis = [0, 1, 0]\ndirection = [1, 0, 0]\nhalf_angle = 1.2\n'
    )
    problem = problem_of(tmp_path, OPEN + "\n" + cone, "goal.tolerance=1e-6")
    tree = grown(name, problem, 1000)
    headings = tree.x[: int(tree.size[0]), 2]
    axles = np.stack([-np.sin(headings), np.cos(headings)])  # the axle is at right angles to it
    assert np.arccos(axles[0]).min() > 1.2
    assert np.arccos(axles[0]).min() < 1.4  # and they come near
    assert tree.rejections[0] > 0


@pytest.mark.parametrize("name", COMPILED)
def test_rates_that_are_no_states_keep_their_limits(name: str, tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "bounds.x_dot=[-0.2, 0.3]", "goal.tolerance=1e-6")
    tree = grown(name, problem, 1000)
    x = tree.x[: int(tree.size[0])]
    rates = 0.25 * x[:, 5] * np.cos(x[:, 2])  # rolling, R = 0.25 m
    assert -0.2 <= rates.min() < -0.1
    assert 0.2 < rates.max() <= 0.3


@pytest.mark.parametrize("name", COMPILED)
def test_no_state_passes_a_limit_between_two_steps(name: str, table: PlanningTask) -> None:
    tree, model = grown(name, table, 2000), table.model
    lower, upper = table.bounds.T
    for node in range(1, int(tree.size[0])):
        x = tree.x[tree.parent[node]]
        for _ in range(tree.steps[node]):
            share = np.array([0.25, 0.5, 0.75, 1.0])
            between = model.step(np.tile(x, (4, 1)), tree.u[node], share * table.step)
            assert (between >= lower).all()
            assert (between <= upper).all()
            x = between[-1]


@pytest.fixture
def trees_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Before its trees, auto looks for a motion in flat outputs."""
    monkeypatch.setattr(auto, "FLAT_ITERATIONS", 0)


@pytest.mark.usefixtures("trees_alone")
@pytest.mark.parametrize("name", COMPILED)
def test_a_search_that_fails_names_what_was_in_the_way(name: str, tmp_path: Path) -> None:
    fence = '\n[[world.obstacle]]\nname = "fence"\nbox = [0.1, 9, 1]\nposition = [-0.5, 0, 0.5]\n'
    problem = problem_of(tmp_path, OPEN + fence, "goal.tolerance=1e-6")
    planner = planners.get(name)(goal_connection_period=0)
    found = planner.solve(problem, 1, Budget(300.0, 500))
    assert found.outcome is Outcome.APPROXIMATE
    assert "coin – fence" in found.rejections["collision"]
    assert found.statistics["propagations"] > 500
    shorter = planner.solve(problem, 1, Budget(300.0, 500, below=9.0))  # there is a motion already
    assert shorter.outcome is not Outcome.SOLVED
    assert not shorter.rejections


@pytest.mark.usefixtures("trees_alone")
@pytest.mark.parametrize("name", COMPILED)
def test_a_goal_that_is_not_hit_by_chance_is_steered_into(name: str, tmp_path: Path) -> None:
    """In fewer iterations than auto makes before its first guess, which would lead there too."""
    problem = problem_of(tmp_path, OPEN, "goal.tolerance=0.001", "goal.at_rest=true")
    led = problem.solve(planner=name, seed=1, max_iterations=3000, goal_connection_period=100)
    assert led.status == "solved"
    assert 1 <= led.statistics["goal_connections"] <= 3000 / 100
    assert led.statistics["goal_connection_propagations"] >= 1
    alone = problem.solve(planner=name, seed=1, max_iterations=3000, goal_connection_period=0)
    assert alone.status != "solved"
    assert not alone.statistics.get("goal_connections")


@pytest.mark.parametrize("samples", [3, 4, 6])
@pytest.mark.parametrize("name", ["kpiece_fast", "rrt_fast"])
def test_inputs_tried_in_lanes_are_those_tried_one_by_one(name: str, samples: int) -> None:
    problem = kinolab.load("submarine_corridor")
    planner = planners.get(name)(control_samples=samples)
    assert isinstance(planner, AbstractCompiledPlanner)
    state = search_state(problem, planner.goal_region_scale, 1)
    assert state.machine.step_in_lanes
    alone = search_state(problem, planner.goal_region_scale, 1)
    alone = alone._replace(machine=alone.machine._replace(step_in_lanes=0))
    trees = []
    for search in (state, alone):
        growth = planner.extension(problem, search)
        growth.begin()
        growth.grow(2000)
        trees.append(growth.nodes)
    size = int(trees[0].size[0])
    assert size == trees[1].size[0] > 20
    np.testing.assert_array_equal(trees[0].x[:size], trees[1].x[:size])
    np.testing.assert_array_equal(trees[0].u[:size], trees[1].u[:size])


def test_a_tree_whose_ends_are_refused_in_truth_begins_anew(
    monkeypatch: pytest.MonkeyPatch, table: PlanningTask
) -> None:
    """It would arrive in the same way again and again."""

    refused: list[int] = []

    def refuse(_: TrueEnds, inputs: Any) -> float:
        refused.append(len(inputs))
        return 2.0

    monkeypatch.setattr(TrueEnds, "excess", refuse)
    monkeypatch.setattr(TrueEnds, "refused", property(lambda _: len(refused)))
    planner = planners.get("kpiece_fast")(goal_connection_period=0, restart_after=0)
    found = planner.solve(table, 1, Budget(30.0, 20_000))
    assert found.outcome is Outcome.APPROXIMATE
    assert found.statistics["restarts"] >= 2
