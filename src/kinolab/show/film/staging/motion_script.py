"""The script of a plan's film: the machine in its world, and its motion; nothing is drawn."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.scenario.schema import RenderSection
from kinolab.show.film.picture import Cone, Ghost, GoalMarker, Picture, Surface
from kinolab.show.film.staging.script import Script
from kinolab.show.film.staging.script_writing import write_script
from kinolab.trajectory import Trajectory
from kinolab.world.geometry import triangles

RENDERED: tuple[Any, ...] = ("view", "azimuth", "elevation", "follow", "cut", "setting")
CONE_LENGTH = 1.25  # of cones, relative to the machine's radius


def motion_script(
    problem: PlanningTask,
    trajectory: Trajectory,
    settings: RenderSection | None = None,
    **options: Any,
) -> Script:
    """Write the script of a trajectory's film, with the scenario's or other settings."""
    settings = settings or problem.scenario.render
    return write_script(
        picture(problem, trajectory.x, settings),
        trajectory.t,
        problem.model.frames(trajectory.x),
        size=settings.size,
        speed=settings.speed,
        title=problem.scenario.title,
        magnify=settings.magnify,
        **options,
    )


def _surfaces(problem: PlanningTask) -> list[Surface]:
    """The obstacles with the colours that the scenario gives them."""
    colors = {entry.name: entry.colors for entry in problem.scenario.world.obstacle}
    return [
        Surface(each.name, each.vertices, each.faces, colors.get(each.name, ()), each.colors)
        for each in (*problem.world.obstacles, *problem.world.floors)
    ]


def picture(problem: PlanningTask, x: np.ndarray, settings: RenderSection | None = None) -> Picture:
    """Return the picture in which bodies and cables move.

    Args:
        problem: The machine and its world.
        x: States along the way, shape (times, nx).
        settings: The scenario's, or others.
    """
    settings = settings or problem.scenario.render
    poses, cables = problem.model.frames(x), problem.model.cables(x)
    down = problem.machine.down
    up = np.array([0.0, 0.0, 1.0]) if down is None else -np.array(down)
    return Picture(
        bodies=problem.bodies,
        obstacles=_surfaces(problem),
        ground=problem.world.ground,
        bounds=problem.world.bounds,
        up=up,
        **{name: getattr(settings, name) for name in RENDERED},
        path=poses[:, problem.leading, 3::4],
        start=Ghost(poses[0], cables[0].reshape(-1, 2, 3)),
        lines=cables if cables.size else None,
        radii=np.array([cable.radius for cable in problem.cables]),
        goal=_goal(problem),
        points=[GoalMarker(point.position, point.tolerance) for point in problem.goal.points],
        cones=list(_cones(problem, poses[0])),
    )


def _cones(problem: PlanningTask, poses: np.ndarray) -> Iterator[Cone]:
    """Yield goal and keep-out cones, with apexes at the start of their bodies."""
    shapes = [shape for body in problem.bodies for shape in body.shapes]
    reaches = [float(np.linalg.norm(triangles(s)[0], axis=1).max()) for s in shapes]
    length = CONE_LENGTH * max(reaches, default=1.0)  # of the machine's radius about its bodies
    for target in problem.goal.directions:
        apex = _place(poses[target.body])
        yield Cone(apex, target.target, target.tolerance, length, forbidden=False)
    for cone in problem.keep_outs:
        apex = _place(poses[cone.body])
        half_angle = cone.forbidden.half_angle
        yield Cone(apex, cone.direction, half_angle, length, forbidden=True)


def _place(pose: np.ndarray) -> tuple[float, float, float]:
    x, y, z = pose[3::4].tolist()
    return x, y, z


def _goal(problem: PlanningTask) -> GoalMarker | Ghost | None:
    """Return the goal's marker: a ball or ring, or the machine at the goal; None if undefined."""
    goal = problem.goal
    if goal.points or goal.directions or not (goal.indices or goal.parts):
        return None  # balls and cones mark them; the rest of the pose is not determined
    x = goal.centre(problem.start)
    pose = problem.frames(x)
    names = [problem.model.state_names[i] for i in goal.indices]
    if set(names) == {"x", "y"}:
        radius = min(goal.tolerances[names.index(name)] for name in ("x", "y"))
        px, py, pz = pose[problem.leading, 3::4]
        return GoalMarker((float(px), float(py), float(pz)), float(radius))
    poses, ends = problem.placement(x)
    return Ghost(poses, ends.reshape(-1, 2, 3))
