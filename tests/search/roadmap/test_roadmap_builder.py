"""Growing a roadmap and asking it: every motion is what it says, answers leave it as it is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.search.roadmap import RoadmapBuilder
from kinolab.simulation.reference import reference_motion
from kinolab.steering import cyclic_coordinates
from tests.scenes import WALL, apart, scene, true_states

Array = np.ndarray


@pytest.fixture(scope="module")
def wall(tmp_path_factory: pytest.TempPathFactory) -> PlanningTask:
    return scene(tmp_path_factory.mktemp("wall"), "drive", text=WALL)


def grown(problem: PlanningTask, count: int, seed: int = 1) -> RoadmapBuilder:
    explorer = RoadmapBuilder(problem, neighbours=4, seed=seed)
    for _ in range(count):
        assert explorer.grow(Budget(60.0)) is not None
    return explorer


@pytest.fixture(scope="module")
def explored(wall: PlanningTask) -> RoadmapBuilder:
    return grown(wall, 25)


def test_milestones_are_free_rest_and_differ(wall: PlanningTask, explored: RoadmapBuilder) -> None:
    milestones = np.array(explored.roadmap.milestones)
    assert len(np.unique(milestones.round(9), axis=0)) == 25
    assert (milestones[:, wall.model.nq :] == 0).all()
    for x in milestones:
        assert not list(wall.limit_violations(x))
        assert not wall.checker().collides(*wall.placement(x))


def test_motions_lead_from_milestone_to_milestone_and_touch_nothing(
    wall: PlanningTask, explored: RoadmapBuilder
) -> None:
    """By DOP853, looked at in the middle of every step too."""
    matters, checker = ~cyclic_coordinates(wall), wall.checker()
    pairs = list(explored.roadmap.motions.items())
    assert len(pairs) >= 20
    for (a, b), inputs in pairs[::9]:
        begin, end = explored.roadmap.milestones[a], explored.roadmap.milestones[b]
        times = wall.step * np.arange(len(inputs) + 1)
        motion = reference_motion(wall, begin, times, inputs)
        assert apart(wall, motion.x[-1], end)[matters].max() < 1e-5
        for k in range(len(inputs)):
            for x in motion.between(k, times[k] + wall.step * np.array([0.5, 1.0])):
                assert not checker.collides(*wall.placement(x))


def test_motions_join_the_nearest_milestones_only(explored: RoadmapBuilder) -> None:
    """Each new milestone is steered to four others at most, both ways."""
    for number in range(25):
        earlier = {pair for pair in explored.roadmap.motions if max(pair) == number}
        assert len(earlier) <= 8


def test_an_answer_leads_to_the_goal_and_leaves_the_roadmap_as_it_is(
    wall: PlanningTask, explored: RoadmapBuilder
) -> None:
    size, motions = len(explored.roadmap.milestones), dict(explored.roadmap.motions)
    goals = explored.goals(3)
    assert all(wall.goal_excess(x) <= 1 for x in goals)
    inputs = explored.query(wall.start, goals, Budget(60.0))
    assert inputs is not None
    assert wall.goal_excess(true_states(wall, wall.start, inputs)[-1]) <= 1
    assert len(explored.roadmap.milestones) == size
    assert explored.roadmap.motions == motions


def test_an_answer_takes_no_longer_than_the_budget(
    wall: PlanningTask, explored: RoadmapBuilder
) -> None:
    goals = explored.goals(1)
    assert explored.query(wall.start, goals, Budget(60.0, max_iterations=0)) is None
    assert explored.query(wall.start, [], Budget(60.0)) is None


def test_the_middle_of_the_goal_comes_first(explored: RoadmapBuilder, wall: PlanningTask) -> None:
    first = explored.goals(1)[0]
    assert wall.goal_distance(first) < 1e-6


def test_the_same_seed_draws_the_same_roadmap_and_another_one_another(wall: PlanningTask) -> None:
    one, same, other = (grown(wall, 4, seed).roadmap for seed in (5, 5, 6))
    assert np.array(one.milestones).tobytes() == np.array(same.milestones).tobytes()
    assert list(one.motions) == list(same.motions)
    for pair, inputs in one.motions.items():
        assert inputs.tobytes() == same.motions[pair].tobytes()
    assert not np.isclose(one.milestones, other.milestones).any(axis=0).all()


def test_a_roadmap_that_grows_again_with_the_same_seed_draws_new_milestones(
    wall: PlanningTask,
) -> None:
    roadmap = grown(wall, 4, seed=5).roadmap
    again = RoadmapBuilder(wall, neighbours=4, seed=5, roadmap=roadmap)
    for _ in range(4):
        again.grow(Budget(60.0))
    assert len(np.unique(np.array(again.roadmap.milestones).round(9), axis=0)) == 8


def test_edges_are_directed_where_a_machine_goes_only_forward(tmp_path: Path) -> None:
    """Gentle turns ahead exist from some places to others and not back."""
    bounds = ("bounds.phi_l_dot=[0, 8]", "bounds.phi_r_dot=[0, 8]", "start.psi=1.0")
    forward = scene(tmp_path, "drive", *bounds)
    explorer = RoadmapBuilder(forward, neighbours=3, seed=2)
    for _ in range(5):
        explorer.grow(Budget(60.0))
    motions = explorer.roadmap.motions
    assert any((b, a) not in motions for a, b in motions)
    for (a, _), inputs in list(motions.items())[::4]:
        states = true_states(forward, explorer.roadmap.milestones[a], inputs)
        assert states[:, 5:].min() > -1e-6


def test_where_nothing_is_free_nothing_grows(tmp_path: Path) -> None:
    """A box fills the hall but for where the robot starts."""
    hall = "\n[[world.obstacle]]\nbox = [9.0, 20.0, 1.0]\nposition = [3.4, 0.0, 0.5]\n"
    problem = scene(tmp_path, "drive", "start.x=-2.0", text=hall)
    explorer = RoadmapBuilder(problem, neighbours=4, seed=1)
    assert explorer.goals(5) == []
