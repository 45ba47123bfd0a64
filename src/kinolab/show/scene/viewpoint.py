"""From where a world is looked at: the direction from which one sees most of the way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.show.scene.camera import AZIMUTH, Angles, Camera, frame_scene, usual_elevation
from kinolab.show.scene.models.surface_mesh import SurfaceMesh, flat_patches, is_room, join
from kinolab.show.scene.picture import Ghost, GoalMarker, Picture
from kinolab.show.scene.sight import SEEN, Screens

STEEPER = np.radians([45.0, 72.0])  # elevations that are tried where walls stand close
MOMENTS, BODIES = 16, 3  # of the way, and of a machine at each of them
FEW, MOST = 5000, 0.97  # faces of a small world, where trying takes no time; what is enough there
FILLING = 0.15  # what a picture that is filled is worth, in fractions of the way
OPEN = 0.75  # fraction of the way that one wants to see; else what hides it is made translucent
DIRECTIONS = 100  # in which the scene's outermost points are looked for
MANY = 400_000  # faces: in larger worlds the usual direction is taken
SIZE = (800, 600)  # [pixel] of the picture in which directions are compared


@dataclass(frozen=True, eq=False)
class Outlook:
    """A direction to look from, and what stands in the way nevertheless.

    Args:
        angles: Azimuth and elevation in [rad].
        seen: Fraction of start, goal and way that is seen, before anything is made translucent.
        veiled: For each obstacle, which of its faces are drawn translucent, shape (m,).
    """

    angles: Angles
    seen: float
    veiled: tuple[NDArray[np.bool_], ...]

    @property
    def hides(self) -> bool:
        """Whether the machine is hidden somewhere, and is to show through."""
        return self.seen < 0.995  # fraction that is seen where nothing hides the machine for long


def outlook(
    picture: Picture,
    meshes: Sequence[SurfaceMesh],
    cloud: Array,
    motion: Array,
    machine: Sequence[SurfaceMesh] = (),
) -> Outlook:
    """Choose the direction from which start, goal and most of the way are seen.

    Args:
        picture: The picture; what it says about its camera is kept.
        meshes: Of its obstacles.
        cloud: Points that the picture must contain, shape (n, 3), in [m].
        motion: Poses of the bodies along the way, shape (nt, nb, 12).
        machine: A mesh of each body; those of obstacles that move hide what is behind them.
    """
    azimuth = -AZIMUTH if picture.azimuth is None else picture.azimuth
    given = picture.elevation
    usual = Angles(azimuth, usual_elevation(cloud, picture.up) if given is None else given)
    nothing = tuple(np.zeros(len(mesh.faces), dtype=bool) for mesh in meshes)
    watched, count = _watched(picture, motion), sum(len(mesh.faces) for mesh in meshes)
    movers = [(k, machine[k]) for k in _prescribed(picture) if k < len(machine)]
    count += sum(len(mesh.faces) for _, mesh in movers)
    if not count or count > MANY or not len(watched[0]):
        return Outlook(usual, 1.0, nothing)
    whole = join(meshes)
    counts = np.array([len(mesh.faces) for mesh in meshes], dtype=int)
    one_sided = np.repeat([*map(is_room, meshes)], counts)
    screens = Screens(whole.vertices, whole.faces, one_sided.astype(bool))
    moving = {k: _placed(movers, motion[k]) for k in np.unique(watched[2]).tolist() if movers}
    sight = _Sight(picture, cloud, screens, *watched, moving)
    best, most = usual, sight.fraction(sight.camera(usual))
    # 0.9: fraction seen from the usual direction with which nothing else is tried
    if picture.view == "perspective" and most < (MOST if count < FEW else 0.9):
        sight = replace(sight, cloud=_outermost(cloud))
        worth = most + FILLING * sight.filled(sight.camera(usual))
        for angles in _others(picture, usual):
            camera = sight.camera(angles)
            seen = sight.fraction(camera)
            value = seen + FILLING * sight.filled(camera)
            if value > worth + 0.04:  # fraction that another direction must show besides
                best, most, worth = angles, seen, value
    if most >= OPEN or not len(whole.faces):
        return Outlook(best, most, nothing)
    ends = np.cumsum([len(mesh.faces) for mesh in meshes])[:-1]
    opened = _opened(sight, sight.camera(best), whole)
    return Outlook(best, most, tuple(np.split(opened, ends)))


def _outermost(cloud: Array) -> Array:
    """The points of a cloud (n, 3) that reach farthest in many directions: enough for framing."""
    k = np.arange(DIRECTIONS) + 0.5
    z, turn = 1.0 - 2.0 * k / DIRECTIONS, np.pi * (1.0 + 5.0**0.5) * k  # a spiral on the sphere
    level = np.sqrt(1.0 - z * z)
    directions = np.stack([level * np.cos(turn), level * np.sin(turn), z])
    reach = directions.T.astype(np.float32) @ cloud.T.astype(np.float32)
    return np.asarray(cloud[np.unique(np.argmax(reach, axis=1))])


@dataclass(frozen=True, eq=False)
class _Sight:
    """What is seen of some weighted points (n, 3) between obstacles, from any direction."""

    picture: Picture
    cloud: Array
    screens: Screens
    points: Array
    weights: Array
    rows: NDArray[np.int64]  # of the motion, at which one wants to see each point
    moving: Mapping[int, Screens]  # obstacles that move, where they are at these rows

    def camera(self, angles: Angles) -> Camera:
        """The camera whose picture has all of the scene."""
        return frame_scene(self.cloud, self.picture.up, self.picture.view, SIZE, angles=angles)

    def filled(self, camera: Camera) -> float:
        """How much of the picture's width and height the scene takes, where it takes less."""
        places = camera.project(self.cloud, SIZE)[:, :2]
        return float(np.min(np.ptp(places, axis=0) / SIZE))

    def fraction(self, camera: Camera) -> float:
        """How much of the points' weight is seen."""
        seen = self.screens.hiding(camera, self.points) == SEEN
        for row, screens in self.moving.items():
            there = self.rows == row
            seen[there] &= screens.hiding(camera, self.points[there]) == SEEN
        return float(self.weights[seen].sum())


def _others(picture: Picture, usual: Angles) -> list[Angles]:
    """Other directions, those near the usual one first."""
    azimuths = [usual.azimuth]
    if picture.azimuth is None:
        azimuths += np.radians([18, -55, 55, -110, 110, 162]).tolist()  # besides the usual one
    elevations = [usual.elevation]
    if picture.elevation is None:
        elevations += [each for each in STEEPER.tolist() if each > usual.elevation + 0.1]
    both = [Angles(azimuth, elevation) for elevation in elevations for azimuth in azimuths]
    return [angles for angles in both if angles != usual]


def _prescribed(picture: Picture) -> list[int]:
    """Obstacles that move, by their places among the bodies."""
    return [k for k, body in enumerate(picture.bodies) if body.prescribed]


def _placed(movers: Sequence[tuple[int, SurfaceMesh]], poses: Array) -> Screens:
    """Bodies with their meshes at one moment, of poses (nb, 12)."""
    placed = []
    for k, mesh in movers:
        g = poses[k].reshape(3, 4)
        placed.append(replace(mesh, vertices=mesh.vertices @ g[:, :3].T + g[:, 3]))
    whole = join(placed)
    return Screens(whole.vertices, whole.faces, np.zeros(len(whole.faces), dtype=bool))


def _watched(picture: Picture, motion: Array) -> tuple[Array, Array, NDArray[np.int64]]:
    """Points that one wants to see, (n, 3), their weights, of sum 1, and rows of the motion.

    Start and goal count for a fifth each, the way for the rest.
    """
    own = np.setdiff1d(np.arange(motion.shape[1]), _prescribed(picture))
    if not len(own) or not len(motion):
        return np.zeros((0, 3)), np.zeros(0), np.zeros(0, dtype=np.int64)
    bodies = own[np.unique(np.linspace(0, len(own) - 1, min(BODIES, len(own))).astype(int))]
    moments = np.unique(np.linspace(0, len(motion) - 1, min(MOMENTS, len(motion))).astype(int))
    way = motion[moments][:, bodies][..., 3::4].reshape(-1, 3)
    start = motion[0, bodies][:, 3::4]
    goal = _goal(picture, bodies)
    parts = [(way, 0.6, np.repeat(moments, len(bodies))), (start, 0.2, np.zeros(len(start), int))]
    parts.append((goal, 0.2, np.full(len(goal), len(motion) - 1)))
    parts = [part for part in parts if len(part[0])]
    weights = np.concatenate([np.full(len(points), w / len(points)) for points, w, _ in parts])
    points, rows = (np.concatenate([part[i] for part in parts]) for i in (0, 2))
    return points, weights / weights.sum(), rows.astype(np.int64)


def _goal(picture: Picture, bodies: NDArray[np.int64]) -> Array:
    if isinstance(picture.goal, Ghost):
        return picture.goal.table[bodies][:, 3::4]
    marks = [*picture.points, *([picture.goal] if isinstance(picture.goal, GoalMarker) else [])]
    return np.array([mark.position for mark in marks], dtype=np.float64).reshape(-1, 3)


def _opened(sight: _Sight, camera: Camera, whole: SurfaceMesh) -> NDArray[np.bool_]:
    """Which faces are made translucent so that one sees the way: large flat ones, as a whole."""
    patches, areas = flat_patches(whole)
    # 2e-3 of all surface: smaller patches hide little, and are left alone
    large = areas[patches] > 2e-3 * areas.sum()
    veiled = np.zeros(len(patches), dtype=bool)
    for _ in range(8):  # layers of walls that are made translucent at most
        left = np.flatnonzero(~veiled)
        hiding = sight.screens.part(left).hiding(camera, sight.points)
        found = left[np.unique(hiding[hiding != SEEN])]
        found = found[large[found]]
        if sight.weights[hiding == SEEN].sum() >= OPEN or not len(found):
            break
        veiled |= np.isin(patches, patches[found])
    return veiled
