"""Words in the picture that say what is what: start, goal, cones, and how long a metre is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from PIL import ImageDraw

from kinolab.numerics.arrays import Array, Bytes
from kinolab.show.film.models.cone import cone_mesh
from kinolab.show.film.models.surface_mesh import SurfaceMesh
from kinolab.show.film.picture import Ghost, GoalMarker
from kinolab.show.film.raster.camera import Camera
from kinolab.show.film.raster.rasterizer import Box
from kinolab.show.film.staging.backdrop import Still
from kinolab.show.film.text import Words, caption, caption_size, heading

START_WORD, GOAL_WORD, TARGET_WORD, AVOID_WORD = "start", "goal", "target", "keep out"
ABOVE = 0.012  # of the picture's height: how far above its thing a word stands
LARGE = 0.3  # of the scene's size: a machine that is larger has its word where it moves most
SHIFTS = (0.0, 0.05, 0.1, -0.04)  # of the picture's height: where a word goes if it has no room
BAR = 0.22  # of the picture's width: the longest scale bar
NUMBERS = (5.0, 2.0, 1.0)  # of a scale bar's length, times a power of ten


@dataclass(frozen=True)
class Caption:
    """A word at a place.

    Args:
        text: The word.
        place: Of what it names, shape (3,), in [m].
    """

    text: str
    place: tuple[float, float, float]


def captions(still: Still) -> Iterator[Caption]:
    """Yield a word for each thing that one cannot know by its look."""
    picture = still.picture
    start, goal = picture.start, picture.goal
    if start is not None:
        yield Caption(START_WORD, _place(still, start, goal))
    if isinstance(goal, Ghost):
        yield Caption(GOAL_WORD, _place(still, goal, start))
    elif isinstance(picture.goal, GoalMarker):
        yield Caption(GOAL_WORD, picture.goal.position)
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
        still: The picture.
        ghost: The machine at one end of its way.
        other: At the other end, if it is shown there: else its first body has the word.
    """
    up = np.asarray(still.picture.up, dtype=np.float64) / np.linalg.norm(still.picture.up)
    bodies, points = _bodies(still.machine, ghost)
    if np.ptp(points, axis=0).max() > LARGE * still.size and len(points):
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


@dataclass(frozen=True, eq=False)
class Signs:
    """All words of a picture, ready to be written on each frame.

    Args:
        words: The words at their places, with the colours of their letters and of what is around.
    """

    words: tuple[tuple[Words, Words], ...]
    colors: tuple[tuple[int, int, int], tuple[int, int, int]]

    def on(self, image: Bytes) -> None:
        """Write them on an image, shape (h, w, 3)."""
        for inner, outer in self.words:
            outer.on(image, self.colors[1])
            inner.on(image, self.colors[0])


def signs(still: Still, camera: Camera, size: tuple[int, int]) -> Signs:
    """Lay out the words of a picture of width and height in [pixel]; none covers another one."""
    words = []
    taken: list[Box] = [(0, 0, size[0], round(0.85 * heading(size[1])))]
    for each in captions(still):
        column, row, depth = camera.project(each.place, size)
        for shift in SHIFTS if depth > 0.0 else ():
            foot = float(row) + (shift - ABOVE) * size[1]
            made = caption(each.text, (float(column), foot), size)
            if made is not None and not any(_meet(made[1].box, other) for other in taken):
                taken.append(made[1].box)
                words.append(made)
                break
    ruler = _scale_bar(still, camera, size)
    if ruler is not None and not any(_meet(ruler[1].box, other) for other in taken):
        words.append(ruler)
    return Signs(tuple(words), (still.words, still.around))


def _meet(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _scale_bar(still: Still, camera: Camera, size: tuple[int, int]) -> tuple[Words, Words] | None:
    """A bar along the near edge of the ground, as long as a round number of metres."""
    edge = _near_edge(still, camera, size)
    if edge is None:
        return None
    ends, length = edge
    step = _round_length(length * BAR * size[0] / max(abs(ends[1, 0] - ends[0, 0]), 1.0))
    text = f"{step:g} m"
    first = ends[0, :2]
    last = first + (ends[1, :2] - first) * min(step / length, 1.0)
    letters = caption_size(size[1])

    def bar(pen: ImageDraw.ImageDraw, width: int) -> None:
        below = np.array([0.0, 0.8 * letters])
        a, b = first + below, last + below
        pen.line([tuple(a), tuple(b)], fill=255, width=2 + 2 * width)
        for end in (a, b):
            tick = np.array([0.0, 0.3 * letters + width])
            pen.line([tuple(end - tick), tuple(end + tick)], fill=255, width=2 + 2 * width)

    middle = 0.5 * (first + last)
    return caption(text, (float(middle[0]), float(middle[1]) + 2.6 * letters), size, bar)


def _near_edge(still: Still, camera: Camera, size: tuple[int, int]) -> tuple[Array, float] | None:
    """The edge of the ground that is lowest in the picture, from left to right, and its length."""
    if still.floor is None:
        return None
    (x0, y0), (x1, y1) = still.floor.low, still.floor.high
    corners = np.array([(x0, y0, 0.0), (x1, y0, 0.0), (x1, y1, 0.0), (x0, y1, 0.0)])
    places = camera.project(corners, size)
    if (places[:, 2] <= 0.0).any():
        return None
    edges = [(k, (k + 1) % 4) for k in range(4)]
    across = np.abs(np.diff(places[edges, :2], axis=1)[:, 0])  # columns and rows that they go
    a, b = max(
        (edge for edge, (x, y) in zip(edges, across, strict=True) if x > y),
        key=lambda edge: float(places[list(edge), 1].sum()),
        default=edges[0],
    )
    if places[a, 0] > places[b, 0]:
        a, b = b, a
    return places[[a, b]], float(np.linalg.norm(corners[b] - corners[a]))


def _round_length(length: float) -> float:
    """The largest of 1, 2, 5, 10, … times a power of ten that is no more than a length in [m]."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(next(number * power for number in NUMBERS if number * power <= length * 1.0001))
