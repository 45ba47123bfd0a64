"""Description of a picture's content, independent of rendering."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.show.film.raster.camera import View

if TYPE_CHECKING:
    from kinolab.world.geometry import BodyGeometry
    from kinolab.world.obstacle import Obstacle

Lines: TypeAlias = Array | Callable[[float], Array]


@dataclass(frozen=True, eq=False)
class Ghost:
    """The machine as a translucent outline, at poses of shape (nb, 12)."""

    poses: Array


@dataclass(frozen=True, eq=False)
class GoalMarker:
    """The goal region: a ring on the ground, or a ball if there is no ground."""

    position: tuple[float, float, float]  # [m]
    radius: float  # [m]


@dataclass(frozen=True, eq=False)
class Cone:
    """A cone of directions that an axis must reach at the goal, or must avoid.

    Args:
        apex: Position of the apex, in [m].
        direction: Of its axis, a unit vector.
        half_angle: In [rad].
        length: In [m].
        forbidden: Whether the axis must keep out of it.
    """

    apex: tuple[float, float, float]
    direction: tuple[float, float, float]
    half_angle: float
    length: float
    forbidden: bool


@dataclass(frozen=True, eq=False)
class Floor:
    """The rectangle of the ground that is drawn, by two opposite corners of shape (2,), in [m]."""

    low: Array
    high: Array


@dataclass(frozen=True, eq=False, kw_only=True)
class Picture:
    """The content of a picture.

    Args:
        obstacles: Static obstacles.
        bodies: Moving bodies; poses are given in the same order.
        ground: Whether the plane z = 0 is drawn; only with ``up`` = z.
        bounds: Limits of the workspace in [m] by axis name; the picture contains them.
        up: Direction that points upward in the picture, shape (3,).
        view: The camera's viewpoint.
        path: Path of the first body's origin, shape (n, 3), in [m].
        start: Poses at which the machine's ghost is drawn.
        goal: A region, or poses for a second ghost.
        cones: Goal cones and keep-out cones of axes.
        lines: Cables: segments of shape (nt, nl, 2, 3) that go with the rows of the motion, or a
            function that gives shape (nl, 2, 3) at a time. Segments that are not finite are slack.
    """

    bodies: Sequence[BodyGeometry]
    obstacles: Sequence[Obstacle] = ()
    ground: bool = False
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    up: Array = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    view: View = "perspective"
    path: Array | None = None
    start: Ghost | None = None
    goal: GoalMarker | Ghost | None = None
    cones: Sequence[Cone] = ()
    lines: Lines | None = None

    @property
    def stands_on_ground(self) -> bool:
        """Whether a floor is drawn: requested, and with z pointing upward."""
        up = np.asarray(self.up, dtype=np.float64)
        return self.ground and bool(up[2] > 0.999 * np.linalg.norm(up))
