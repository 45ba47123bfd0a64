"""The camera that goes with the machine: on each part of the way from a side where no wall is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.show.scene.camera import WIDE, to_viewer
from kinolab.show.scene.models.surface_mesh import SurfaceMesh, is_room
from kinolab.show.scene.picture import Picture
from kinolab.show.scene.viewpoint import MANY

AZIMUTHS = np.radians(-32.0 + 30.0 * np.arange(12))  # the first one where all are free
ELEVATIONS = (0.62, 1.0, 1.35)  # [rad], the usual one first


def follow_track(
    picture: Picture, obstacles: Sequence[SurfaceMesh], times: Array, motion: Array, reach: float
) -> Array:
    """Where the camera is that goes with the machine: time, azimuth, elevation, shape (n, 3).

    Args:
        picture: What is seen.
        obstacles: What may be in between.
        times: Of the poses in [s], shape (nt,).
        motion: Poses of the bodies, shape (nt, nb, 12).
        reach: How far the machine reaches from the middle of its bodies, in [m].
    """
    # 25 moments of a motion at which the camera's place is chosen
    rows = np.unique(np.linspace(0, len(times) - 1, min(25, len(times))).astype(int))
    middles = motion[rows][:, :, 3::4].mean(axis=1)
    looks = [(float(a), e) for e, a in product(ELEVATIONS, AZIMUTHS)]
    up = np.asarray(picture.up, dtype=np.float64) / np.linalg.norm(picture.up)
    directions = to_viewer(up, *np.array(looks).T[..., None])
    # 3.6 radii of the machine in the picture, as the page has it
    rays = 3.6 * reach / np.tan(WIDE / 2.0) * directions
    # In larger worlds the camera keeps its side.
    walls = _Walls.of(obstacles) if sum(len(m.faces) for m in obstacles) <= MANY else None
    chosen, before = [], looks[0]
    for middle in middles:
        if walls is not None:
            before = _nearest_free(looks, rays, walls, middle, before)
        chosen.append(before)
    angles = np.array(chosen)
    angles[:, 0] = np.unwrap(angles[:, 0])
    return np.column_stack([times[rows], angles])


def _nearest_free(
    looks: list[tuple[float, float]],
    rays: Array,
    walls: _Walls,
    middle: Array,
    before: tuple[float, float],
) -> tuple[float, float]:
    """The free direction that is least away from the one before and from the usual height."""

    def effort(k: int) -> float:
        turn = abs(np.angle(np.exp(1j * (looks[k][0] - before[0]))))
        # 0.6 [rad] of turning that one would rather do than look from higher above
        return float(turn + 0.6 * ELEVATIONS.index(looks[k][1]))

    order = sorted(range(len(looks)), key=effort)
    free = next((k for k in order if not walls.cross(middle, rays[k])), None)
    return (before[0], max(ELEVATIONS)) if free is None else looks[free]


@dataclass(frozen=True, eq=False)
class _Walls:
    """Faces that a line of sight may cross: corners (m, 3, 3), their boxes, which are of rooms."""

    corners: Array
    low: Array
    high: Array
    room: NDArray[np.bool_]

    @classmethod
    def of(cls, obstacles: Sequence[SurfaceMesh]) -> _Walls:
        corners = [mesh.vertices[mesh.faces] for mesh in obstacles]
        rooms = [np.full(len(mesh.faces), is_room(mesh)) for mesh in obstacles]
        all_corners = np.concatenate([np.zeros((0, 3, 3)), *corners])
        low, high = all_corners.min(axis=1), all_corners.max(axis=1)
        return cls(all_corners, low, high, np.concatenate([np.zeros(0, dtype=bool), *rooms]))

    def cross(self, origin: Array, ray: Array) -> bool:
        """Whether a face lies between a point and the end of a ray from it.

        Faces of a room count only where they look at the camera. Source: Möller and Trumbore, Fast,
        Minimum Storage Ray-Triangle Intersection, 1997.
        """
        first, last = np.minimum(origin, origin + ray), np.maximum(origin, origin + ray)
        near = np.ones(len(self.low), dtype=bool)
        for axis in range(3):
            near &= (self.low[:, axis] <= last[axis]) & (self.high[:, axis] >= first[axis])
        corners = self.corners[near]
        if not len(corners):
            return False
        a, b, c = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        p, s = np.cross(ray, c), origin - a
        q = np.cross(s, b)
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1.0 / np.sum(p * b, axis=1)
            u, v = np.sum(p * s, axis=1) * inverse, (q @ ray) * inverse
            t = np.sum(q * c, axis=1) * inverse
            # 0.15 of the distance to the camera, from the machine: what is so close hides little
            hit = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 0.15) & (t < 1.0)
        return bool((hit & (~self.room[near] | (np.cross(b, c) @ ray > 0.0))).any())
