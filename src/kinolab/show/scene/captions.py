"""Words that say what is what in a scene: start, goal, cones."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.show.scene.models.cone import cone_mesh
from kinolab.show.scene.models.surface_mesh import SurfaceMesh
from kinolab.show.scene.picture import Ghost, GoalMarker
from kinolab.show.scene.still import Still

START_WORD, GOAL_WORD, TARGET_WORD, AVOID_WORD = "start", "goal", "target", "keep out"


@dataclass(frozen=True)
class Caption:
    """A word at a place.

    Args:
        place: Of what it names, shape (3,), in [m].
    """

    text: str
    place: tuple[float, float, float]


def captions(still: Still) -> Iterator[Caption]:
    """Yield a word for each thing that one cannot know by its look."""
    picture = still.picture
    start, goal = picture.start, picture.goal
    if picture.others:  # each machine has its own start and goal
        start = goal = None
    if start is not None:
        yield Caption(START_WORD, _place(still, start, goal))
    if isinstance(goal, Ghost):
        yield Caption(GOAL_WORD, _place(still, goal, start))
    elif isinstance(goal, GoalMarker):
        yield Caption(GOAL_WORD, goal.position)
    for point in picture.points:
        yield Caption(GOAL_WORD, point.position)
    for cone in picture.cones:
        points = cone_mesh(cone).vertices
        x, y, z = points[np.argmax(points @ np.asarray(picture.up))].tolist()
        yield Caption(AVOID_WORD if cone.forbidden else TARGET_WORD, (x, y, z))


def _place(
    still: Still, ghost: Ghost, other: Ghost | GoalMarker | None
) -> tuple[float, float, float]:
    """The middle of a machine's upper side; where it is large, the point that moves most.

    Args:
        ghost: The machine at one end of its way.
        other: At the other end, if it is shown there: else its first body has the word.
    """
    up = np.asarray(still.picture.up, dtype=np.float64) / np.linalg.norm(still.picture.up)
    bodies, points = _bodies(still.machine, ghost)
    # 0.3 of the scene's size: a machine that is larger has its word where it moves most
    if np.ptp(points, axis=0).max() > 0.3 * still.size and len(points):
        if isinstance(other, Ghost):
            moved = np.linalg.norm(points - _bodies(still.machine, other)[1], axis=1)
            x, y, z = points[moved.argmax()].tolist()
            return x, y, z
        points = bodies[0] if len(bodies[0]) else points
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    x, y, z = (middle + up * (float((points @ up).max()) - float(middle @ up))).tolist()
    return x, y, z


def _bodies(machine: Sequence[SurfaceMesh], ghost: Ghost) -> tuple[list[Array], Array]:
    """The points of each body, and those and the bodies' origins together."""
    bodies = [mesh.vertices for mesh in ghost.placed(machine)]
    return bodies, np.concatenate([ghost.table[:, 3::4], *bodies])
