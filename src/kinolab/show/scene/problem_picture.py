"""The picture of a problem: the machine in its world, its way, its start and its goal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from kinolab.dynamics.language.shapes import Shape
from kinolab.problem import PlanningTask
from kinolab.scenario.schema import RenderSection
from kinolab.show.scene.goal_mark import goal_mark, hidden_obstacles
from kinolab.show.scene.models.cone import Cone
from kinolab.show.scene.picture import Frames, Ghost, GoalMarker, Picture, Surface
from kinolab.world.distances.placed_shapes import MANY
from kinolab.world.shapes.geometry import triangles

RENDERED: tuple[Any, ...] = ("view", "azimuth", "elevation", "follow", "cut", "setting")
WORLD = "world"  # name of its frame


def _surfaces(problem: PlanningTask) -> list[Surface]:
    """The obstacles with the colours that the scenario gives them; of many, all others as one."""
    colors = {entry.name: entry.colors for entry in problem.scenario.world.obstacle}
    shown = [
        Surface(each.name, *each.picture(), colors.get(each.name, ()), each.colors)
        for each in (*problem.world.obstacles, *problem.world.floors)
    ]
    plain = [each for each in shown if not each.colors and each.paint is None]
    if len(shown) <= MANY or not plain:
        return shown
    first = np.cumsum([0, *(len(each.vertices) for each in plain)])
    vertices = np.concatenate([each.vertices for each in plain])
    faces = np.concatenate([each.faces + k for each, k in zip(plain, first, strict=False)])
    coloured = [each for each in shown if each.colors or each.paint is not None]
    return [*coloured, Surface("obstacles", vertices, faces)]


def picture(problem: PlanningTask, x: np.ndarray, settings: RenderSection | None = None) -> Picture:
    """Return the picture in which bodies and cables move.

    Args:
        x: States along the way, shape (times, nx).
        settings: The scenario's, or others.
    """
    settings = settings or problem.scenario.render
    poses, cables = problem.model.frames(x), problem.model.cables(x)
    down = problem.machine.down
    up = np.array([0.0, 0.0, 1.0]) if down is None else -np.array(down)
    drawn = path_body(problem, poses)
    path = poses[:, drawn, 3::4]
    leaders = [k for k in problem.leaders if k != drawn]
    return Picture(
        bodies=problem.bodies,
        obstacles=_surfaces(problem),
        ground=problem.world.ground,
        bounds=problem.world.bounds,
        up=up,
        **{name: getattr(settings, name) for name in RENDERED},
        path=path,
        others=[poses[:, k, 3::4] for k in leaders] if len(leaders) < len(problem.leaders) else [],
        rolls=_rolls(problem, drawn, poses[:, drawn]),
        frames=frames_of(problem, x, poses) if settings.axes else None,
        start=Ghost(hidden_obstacles(problem, poses[0]), cables[0].reshape(-1, 2, 3)),
        lines=cables if cables.size else None,
        radii=np.array([cable.radius for cable in problem.cables]),
        goal=goal_mark(problem, x),
        points=[*_points(problem)],
        cones=list(_cones(problem, poses[0])),
    )


def _points(problem: PlanningTask) -> Iterator[GoalMarker]:
    """Yield where points of bodies go, and where the leading body is in goals on the way."""
    for goal in (*problem.via, problem.goal):
        yield from (GoalMarker(point.position, point.tolerance) for point in goal.points)
    for goal in problem.via:
        if goal.indices:
            pose = problem.frames(goal.centre(problem.start))[problem.leading]
            yield GoalMarker(_place(pose), float(goal.tolerances.min()))


def frames_of(problem: PlanningTask, x: np.ndarray, poses: np.ndarray) -> Frames:
    """Return the frames of the world, of joints and of bodies at states (nt, nx)."""
    joints = problem.machine.joints
    names = (WORLD, *joints.names, *(body.name for body in problem.bodies))
    world = np.broadcast_to(np.eye(3, 4).ravel(), (len(x), 1, 12))
    at = joints.at(x, problem.model.coordinate_names)
    return Frames(names, np.concatenate([world, at, poses], axis=1))


def path_body(problem: PlanningTask, poses: np.ndarray) -> int:
    """Return the body whose path is drawn: the leading one, or the next that leaves its place.

    Args:
        poses: Along the way, shape (nt, nb, 12).
    """
    # 1e-6 [m]; a body that goes less turns in its place
    goes = np.ptp(poses[..., 3::4], axis=0).max(axis=-1) > 1e-6
    order = [problem.leading, *problem.moving.tolist()]
    seen = [k for k in order if problem.bodies[k].shapes or problem.bodies[k].drawn]
    return next((k for k in seen if goes[k]), problem.leading)


def _rolls(problem: PlanningTask, body: int, poses: np.ndarray) -> bool:
    """Whether the path of a body is a track on the ground, and not a way through the air.

    It is one where the body's origin is never higher than it reaches, and the gap below it never
    larger than it is high: a plank on a high pivot is long, and yet in the air.

    Args:
        poses: Along the way, shape (nt, 12).
    """
    shapes = problem.bodies[body].shapes
    # 1.01 of a body's reach: as high is its origin at most while it touches the ground
    if poses[:, 11].max(initial=0.0) > 1.01 * max(map(_reach, shapes), default=0.0):
        return False
    corners = np.concatenate([np.zeros((1, 3)), *(triangles(shape)[0] for shape in shapes)])
    heights = poses[:, 8:11] @ corners.T + poses[:, 11:]
    return bool(np.all(heights.min(axis=1) <= np.ptp(heights, axis=1)))


def _reach(shape: Shape) -> float:
    """How far a shape reaches from its body's origin, in [m]."""
    return float(np.linalg.norm(triangles(shape)[0], axis=1).max())


def _cones(problem: PlanningTask, poses: np.ndarray) -> Iterator[Cone]:
    """Yield goal and keep-out cones, with apexes at the start of their bodies."""
    reaches = [_reach(shape) for body in problem.bodies for shape in body.shapes]
    # 1.25 of cones, relative to the machine's radius
    length = 1.25 * max(reaches, default=1.0)  # of the machine's radius about its bodies
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
