"""What a viewer shows of a page's content: coloured triangles that stand still or move."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.robots.writing.fresh_names import fresh_name
from kinolab.show.scene.content import Content
from kinolab.show.scene.curves import evaluated
from kinolab.show.scene.models.ground import floor_top
from kinolab.show.scene.models.surface_mesh import Indices, SurfaceMesh
from kinolab.show.scene.still import extent

FRAMES_PER_SECOND = 30.0


class ViewedPart(NamedTuple):
    """An obstacle, the floor or a body.

    Attributes:
        name: Unique among its kind.
        vertices: Three for each triangle, shape (3 n, 3), in [m].
        colors: Of each vertex, red, green and blue in [0, 1], shape (3 n, 3).
        places, turns: Of a body at ``times``, shapes (m, 3) and (m, 4), quaternions x, y, z, w; no
            rows of what stands still.
    """

    name: str
    vertices: Array
    colors: Array
    places: Array = np.zeros((0, 3))
    turns: Array = np.zeros((0, 4))

    @property
    def triangles(self) -> Indices:
        """The vertices of each triangle, shape (n, 3)."""
        return np.arange(len(self.vertices)).reshape(-1, 3)


def times_of(content: Content) -> Array:
    """Return when the motion is shown, evenly spaced, shape (m,) in [s]."""
    end = float(content.knots[-1])
    return np.linspace(0.0, end, max(round(end * FRAMES_PER_SECOND), 1) + 1)


def still_parts(content: Content) -> Iterator[ViewedPart]:
    """Yield floor and obstacles."""
    still = extent(content).still
    if still.floor is not None:
        yield _part("floor", floor_top(still.floor.low, still.floor.high, content.picture.colors))
    names = unique([obstacle.name for obstacle in content.picture.obstacles])
    for name, mesh in zip(names, still.obstacles, strict=True):
        yield _part(name, mesh)


def moving_parts(content: Content) -> Iterator[ViewedPart]:
    """Yield the bodies that have a shape."""
    times, keys, picture = times_of(content), content.keys, content.picture
    names = unique([body.name for body in picture.bodies])
    for k, (name, mesh) in enumerate(zip(names, picture.machine(), strict=True)):
        if len(mesh.faces):
            turns = evaluated(keys.turns[k], times)
            turns /= np.linalg.norm(turns, axis=1, keepdims=True)
            part = _part(name, mesh)
            yield part._replace(places=evaluated(keys.places[k], times), turns=turns)


def cables_at(content: Content) -> Array:
    """Return the ends of all cables at ``times_of``, shape (m, cables, 2, 3), in [m]."""
    times = times_of(content)
    if content.keys.ends is None:
        return np.zeros((len(times), 0, 2, 3))
    return evaluated(content.keys.ends, times).reshape(len(times), -1, 2, 3)


def unique(names: Sequence[str]) -> list[str]:
    """Return names for paths in a tree, each of its own."""
    taken: set[str] = set()
    return [fresh_name(name.replace("/", " ") or "part", taken) for name in names]


def _part(name: str, mesh: SurfaceMesh) -> ViewedPart:
    vertices = np.asarray(mesh.vertices)[mesh.faces].reshape(-1, 3)
    return ViewedPart(name, vertices, np.repeat(mesh.colors, 3, axis=0))
