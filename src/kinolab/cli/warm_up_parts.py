"""Parts of the warm-up: each one compiles its functions by calling them on a small problem.

Functions are compiled for the types of their arguments, not for a machine or a world, so that a
coin among four obstacles represents all.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import numpy as np

from kinolab import planners
from kinolab.analyze.simulate import simulate
from kinolab.errors import MissingPlannerError
from kinolab.loading import build_problem
from kinolab.problem import PlanningTask
from kinolab.scenario import scenario_from
from kinolab.search.flat.flat_search import FlatConnection
from kinolab.search.tree import AbstractCompiledPlanner, search_state
from kinolab.show.film.animation import animate
from kinolab.simulation.resimulated_goal import resimulated_violation
from kinolab.solve import make_planner
from kinolab.trajectory import Trajectory
from kinolab.trajopt import make_exact
from kinolab.verification import verify
from kinolab.world import World
from kinolab.world.collision.clearance_bound import ClearanceBound
from kinolab.world.collision.collision_scene import collision_scene
from kinolab.world.collision.distance_field import distance_field
from kinolab.world.collision.fcl import FclTiles


def small_problem() -> PlanningTask:
    """Return a coin among one obstacle of every kind."""
    text = files("kinolab.cli").joinpath("warm_up.toml").read_text("utf-8")
    problem = build_problem(scenario_from(tomllib.loads(text), Path("warm_up.toml")), planner=False)
    box, *others = problem.world.obstacles
    mesh = replace(box, primitive=None)  # its triangles only
    return replace(problem, world=World((mesh, *others), True, problem.world.bounds))


def simulated() -> tuple[PlanningTask, Trajectory]:
    """Return the small problem with a motion of its machine."""
    problem = small_problem()
    return problem, simulate(problem, 0.2)  # [s] of the motion that is verified and rendered


def compiled_planners() -> Iterator[str]:
    """Yield the names of kinolab's planners whose loops are compiled."""
    for name in planners.built_in():
        with suppress(MissingPlannerError):
            if issubclass(planners.get(name), AbstractCompiledPlanner):
                yield name


def _planners() -> None:
    problem = small_problem()
    for name in compiled_planners():
        planner = make_planner(problem, name, {})
        assert isinstance(planner, AbstractCompiledPlanner)
        growth = planner.extension(problem, search_state(problem, planner.goal_region_scale, 1))
        growth.begin()
        growth.grow(0)
        growth.grow(1)
    FlatConnection(problem, 1, reach=1.0, max_nodes=128).prepare()
    resimulated_violation(problem, np.zeros((1, problem.model.nu)))


def _collision() -> None:
    problem, motion = simulated()
    # 0.1 [m] is the resolution of a sample
    distance_field(problem.world.obstacles, 0.1)  # may be cached on disk
    verify(problem, motion)
    checker = problem.checker()
    bound = ClearanceBound(collision_scene(problem.bodies, problem.world))
    inside = np.tile(problem.start, (len(problem.world.obstacles), 1))  # states of collision
    inside[:, :2] = [obstacle.vertices.mean(axis=0)[:2] for obstacle in problem.world.obstacles]
    for x in (problem.start, *inside):
        poses, ends = problem.placement(x)
        checker.contacts(poses, ends)
        checker.clearance(poses, ends)
        bound.within(poses, ends, 1.0)
    for obstacle in problem.world.obstacles:
        list(FclTiles(obstacle.vertices, obstacle.faces).near(np.zeros(6)))


def _potential_fields() -> None:
    from kinolab.search.potential.eikonal import WorkspaceGrid, navigation_function
    from kinolab.world.collision.closest_points import GapFinder

    problem = small_problem()
    poses, _ = problem.placement(problem.start)
    bodies = [replace(body, touches_ground=False) for body in problem.bodies]
    GapFinder(bodies, problem.world, 1.0).gaps(poses)
    for axes in ((0, 1), (0, 1, 2)):
        free = np.ones((4,) * len(axes), dtype=bool)
        grid = WorkspaceGrid(axes, np.zeros(len(axes)), 1.0, free.shape)
        navigation_function(free, grid, np.ones(3), 1.0)


# The longest part comes first, so that no processor idles at the end.
PARTS: dict[str, Callable[[], object]] = {
    "ways around obstacles": _potential_fields,
    "planners": _planners,
    "collision": _collision,
    "pictures": lambda: animate(*simulated()),
    "optimisation": lambda: make_exact(*simulated()),
}
