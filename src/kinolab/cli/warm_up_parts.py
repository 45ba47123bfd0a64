"""Parts of the warm-up: each one compiles its functions by calling them on a small problem.

Functions are compiled for the types of their arguments, not for a machine or a world, so that a
coin among four obstacles represents all.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
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
from kinolab.search.ompl.goal_errors import GoalErrors
from kinolab.search.tree import AbstractCompiledPlanner, search_state
from kinolab.search.tree.threads import AbstractThreadedPlanner
from kinolab.show.film import drawing
from kinolab.show.film.animation import animate
from kinolab.simulation.resimulated_goal import resimulated_violation
from kinolab.solve import make_planner
from kinolab.trajectory import Trajectory
from kinolab.trajopt import make_exact
from kinolab.verification import verify
from kinolab.verification.lower_bound.duration_bound import duration_bound
from kinolab.world import World
from kinolab.world.collision.broadphase import clear_of_meshes
from kinolab.world.collision.clearance_bound import ClearanceBound
from kinolab.world.collision.collision_scene import collision_scene
from kinolab.world.collision.fcl import FclTiles
from kinolab.world.distances.distance_field import distance_field


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
        state = search_state(problem, planner.goal_region_scale, 1)
        growth = planner.extension(problem, state)
        growth.begin()
        growth.grow(0)
        growth.grow(1)
        if isinstance(planner, AbstractThreadedPlanner):
            with closing(replace(planner, threads=2).extension(problem, state)) as shared:
                shared.begin()
                shared.grow(0)
    flat = FlatConnection(problem, 1, reach=1.0, max_nodes=128)
    flat.prepare()
    flat.compile_for_cars()
    GoalErrors(problem, 1.0).fractions(problem.start.tolist())
    resimulated_violation(problem, np.zeros((1, problem.model.nu)))
    with suppress(ImportError):  # Gymnasium is an extra
        from kinolab.gym.step_batch import StepBatch

        batch = StepBatch(problem, 1, reward="shaped", starts="scenario", duration=1.0)
        batch.reset(0, np.random.default_rng(0))
        batch.step(np.zeros((1, problem.model.nu)))


def _collision() -> None:
    problem, motion = simulated()
    # 0.1 [m] is the resolution of a sample
    distance_field(problem.world.obstacles, 0.1)  # may be cached on disk
    verify(problem, motion)
    duration_bound(problem)
    checker = problem.checker()
    bound = ClearanceBound(collision_scene(problem.bodies, problem.world))
    inside = np.tile(problem.start, (len(problem.world.obstacles), 1))  # states of collision
    inside[:, :2] = [obstacle.vertices.mean(axis=0)[:2] for obstacle in problem.world.obstacles]
    for x in (problem.start, *inside):
        poses, ends = problem.placement(x)
        checker.collides(poses, ends)
        checker.contacts(poses, ends)
        checker.clearance(poses, ends)
        bound.within(poses, ends, 1.0)
    clear_of_meshes(0, checker._arrays)  # which a report asks of large meshes alone
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


def _pictures() -> None:
    drawing.load()
    animate(*simulated())


# The longest part comes first, so that no processor idles at the end.
PARTS: dict[str, Callable[[], object]] = {
    "ways around obstacles": _potential_fields,
    "planners": _planners,
    "collision": _collision,
    "pictures": _pictures,
    "optimisation": lambda: make_exact(*simulated()),
}
