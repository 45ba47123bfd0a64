"""The roadmap of configurations: what is free at rest, where it leads, and no trace left."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.search.roadmap import ConfigurationSpace, GeometricRoadmap
from kinolab.steering import Steering
from tests.scenes import WALL, scene


def configurations(problem: PlanningTask, margin: float = 0.02) -> ConfigurationSpace:
    return ConfigurationSpace(problem, Steering(problem), goal_of(problem), margin)


def goal_of(problem: PlanningTask) -> np.ndarray:
    x = problem.model.rest()
    x[list(problem.goal.indices)] = problem.goal.targets
    return x


@pytest.mark.parametrize("at", np.linspace(-0.5, 0.5, 11).round(1).tolist())
def test_a_thin_wall_anywhere_across_a_long_way_separates_its_ends(
    at: float, tmp_path: Path
) -> None:
    """Of 9 m, a robot that is 0.4 m long: twelve looks would be 0.8 m apart."""
    wall = f"[[world.obstacle]]\nbox = [0.01, 10.0, 1.0]\nposition = [{at}, 0.0, 0.5]\n"
    problem = scene(tmp_path, "drive", "start.x=-4.5", "goal.x=4.5", text=wall)
    assert not configurations(problem).joined(problem.start, goal_of(problem))


@pytest.mark.parametrize(
    ("machine", "free"),
    [
        ("drive", ["x", "y", "psi"]),
        ("car", ["x", "y", "psi"]),
        ("coin", ["x", "y", "psi"]),
        ("crane", ["x", "y", "l"]),
        ("two_cranes", ["x_a", "l_a", "x_b", "l_b"]),
        ("pendulum", []),
    ],
)
def test_what_rest_leaves_free_tells_configurations_apart(
    machine: str, free: list[str], tmp_path: Path
) -> None:
    """Not a wheel's rotation, not a car's steering, not the sway of a load."""
    problem = scene(tmp_path, machine)
    found = configurations(problem)
    assert found.differ == bool(free)
    if not free:
        return
    generator = np.random.default_rng(2)
    for _ in range(5):
        x = problem.sample_goal(generator)
        read = found.equilibrium(x)
        assert read is not None
        kept = [problem.model.state_names.index(name) for name in free]
        turned = np.where(problem.circular, np.exp(1j * read), read)[kept]
        assert turned == pytest.approx(np.where(problem.circular, np.exp(1j * x), x)[kept])
        assert read[problem.model.nq :] == pytest.approx(0.0)
        assert problem.model.f(read, held(problem)) == pytest.approx(0.0, abs=1e-6)


def held(problem: PlanningTask) -> np.ndarray:
    """The inputs at rest: the weight of the crane's load, or none."""
    return (
        np.array([0, 0, 9810.0]) if problem.system.name == "crane" else np.zeros(problem.model.nu)
    )


@pytest.mark.parametrize(
    "overrides",
    [
        (),
        ("start.phi_l=5.0", "start.phi_r=-3.0"),
        ("start.psi=4.0",),
        ("start.psi=-3.141592653589793",),
        ("start.phi_l_dot=2.0",),
        ("goal.psi=9.0",),
    ],
)
def test_a_path_leads_from_any_start_at_rest_to_the_goal_with_room(
    overrides: tuple[str, ...], tmp_path: Path
) -> None:
    problem = scene(tmp_path, "drive", *overrides, text=WALL)
    found, goal = configurations(problem, margin=0.05), goal_of(problem)
    roadmap = GeometricRoadmap(found, problem.start, goal, 1, 8)
    path = roadmap.path()
    assert path is None  # the wall is in between
    while path is None and roadmap.size < 300:
        roadmap.grow(20, Budget(60.0))
        path = roadmap.path()
    assert path is not None
    assert path[0][:2] == pytest.approx(problem.start[:2])
    assert path[-1][:2] == pytest.approx(goal[:2])
    for x, wanted in ((path[0], problem.start), (path[-1], goal)):
        assert np.exp(1j * x[2]) == pytest.approx(np.exp(1j * wanted[2]))
    checker = problem.checker(margin=0.05)
    for x in path:
        assert not checker.collides(*problem.placement(x))
        assert x[5:] == pytest.approx([0, 0])
    for x0, x1 in pairwise(path):
        assert next(found.free_paths(x0, x1), None) is not None


def test_the_same_seed_grows_the_same_roadmap(tmp_path: Path) -> None:
    problem = scene(tmp_path, "drive", text=WALL)
    paths = []
    for seed in (4, 4, 5):
        roadmap = GeometricRoadmap(
            configurations(problem), problem.start, goal_of(problem), seed, 4
        )
        path = None
        while path is None:
            roadmap.grow(10, Budget(60.0))
            path = roadmap.path()
        paths.append(np.array(path).tobytes())
    assert paths[0] == paths[1] != paths[2]


def test_growing_ends_with_the_budget(tmp_path: Path) -> None:
    problem = scene(tmp_path, "drive", text=WALL)
    roadmap = GeometricRoadmap(configurations(problem), problem.start, goal_of(problem), 1, 8)
    budget = Budget(60.0, max_iterations=5)
    roadmap.grow(1000, budget)
    assert budget.iterations == 5
    assert roadmap.size < 20


@pytest.mark.parametrize("overrides", [("start.psi=4.0", "start.phi_l_dot=1.0")])
def test_the_robot_follows_a_path_around_the_wall(
    overrides: tuple[str, ...], tmp_path: Path
) -> None:
    problem = scene(tmp_path, "drive", *overrides, text=WALL)
    found = problem.solve(planner="prm_geometric", seed=1, time_limit=60.0, max_iterations=3000)
    assert found.status == "solved"


@pytest.mark.parametrize(
    ("machine", "overrides"), [("car", ("start.delta=0.2",)), ("crane", ()), ("coin", ())]
)
def test_flat_machines_follow_their_paths(
    machine: str, overrides: tuple[str, ...], tmp_path: Path
) -> None:
    problem = scene(tmp_path, machine, *overrides)
    found = problem.solve(planner="prm_geometric", seed=1, time_limit=60.0, max_iterations=3000)
    assert found.status == "solved"


@pytest.mark.parametrize("machine", ["pendulum", "submarine", "stone"])
def test_where_no_configuration_can_be_told_apart_nothing_is_found_at_once(
    machine: str, tmp_path: Path
) -> None:
    """A weak pendulum slides back to where it hangs; attitudes know no straight line."""
    found = scene(tmp_path, machine).solve(planner="prm_geometric", seed=1, time_limit=30.0)
    assert found.status == "not_found"
    assert found.timings["search"] < 5.0  # [s]
