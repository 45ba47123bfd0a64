"""Pinhole camera: projection of world points, and framing of a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from kinolab.numerics.arrays import Array

View: TypeAlias = Literal["perspective", "top", "front", "side"]


@dataclass(frozen=True)
class Angles:
    """The direction from which one looks.

    Args:
        azimuth: From the front view counterclockwise about the vertical, in [rad]: pi / 2 looks
            from the right.
        elevation: Above the horizon, in [rad].
    """

    azimuth: float
    elevation: float


WIDE, NARROW = np.radians(30.0), np.radians(8.0)  # corner view; nearly parallel plans
AZIMUTH = np.radians(18.0)  # off the front view, so that two sides of a box are visible
FLAT, TALL = np.radians(58.0), np.radians(20.0)  # elevation over a flat scene, and for a tall one


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera that looks from ``position`` to ``target``.

    Args:
        position: The pinhole, shape (3,), in [m].
        target: The point in the middle of the picture, shape (3,), in [m].
        up: A direction that points upward in the picture, shape (3,), not along the line of sight.
        fov: Vertical angle of view in [rad], in (0, pi).
    """

    position: Array
    target: Array
    up: Array
    fov: float

    @cached_property
    def axes(self) -> Array:
        """Right, upward and forward as the rows of a rotation matrix, shape (3, 3)."""
        forward = _unit(self.target - self.position)
        right = _unit(np.cross(forward, self.up))
        return np.stack([right, np.cross(right, forward), forward])

    def project(self, points: ArrayLike, size: tuple[int, int]) -> Array:
        """Map points of the world, shape (..., 3), to column, row and depth, shape (..., 3).

        Columns grow to the right and rows downward from the upper left corner, in [pixel]; the
        centre of pixel (0, 0) is (0.5, 0.5). The depth in [m] is measured along the line of sight.
        """
        width, height = size
        seen = (np.asarray(points, dtype=np.float64) - self.position) @ self.axes.T
        depth = seen[..., 2]
        focal = 0.5 * height / np.tan(0.5 * self.fov)
        with np.errstate(divide="ignore", invalid="ignore"):  # in the pinhole's plane: at infinity
            column = 0.5 * width + focal * seen[..., 0] / depth
            row = 0.5 * height - focal * seen[..., 1] / depth
        return np.stack([column, row, depth], axis=-1)

    def nearest_pixel(self, paths: Sequence[Array], size: tuple[int, int]) -> float:
        """Size of a pixel in [m] where points (..., 3) come nearest; 0 without any."""
        if not paths:
            return 0.0
        nearest = min(float(self.project(path, size)[..., 2].min()) for path in paths)
        return float(2.0 * nearest * np.tan(0.5 * self.fov) / size[1])


def horizontal_axes(up: ArrayLike) -> tuple[Array, Array]:
    """The directions (3,) to the right of a front view and toward its viewer.

    For up = z these are x and -y; for a machine in the x-y plane with up = -x they are y and z.
    """
    upward = _unit(np.asarray(up, dtype=np.float64))
    across = np.zeros(3)
    across[1 if np.argmax(np.abs(upward)) == 0 else 0] = 1.0
    across = _unit(across - upward * (upward @ across))
    return across, np.cross(across, upward)


def frame_scene(
    points: ArrayLike,
    up: ArrayLike = (0.0, 0.0, 1.0),
    view: View = "perspective",
    size: tuple[int, int] = (800, 600),
    margin: tuple[float, float] = (0.04, 0.075),
    angles: Angles | None = None,
) -> Camera:
    """Choose the nearest camera whose picture contains every point.

    Args:
        points: Points to be visible, shape (n, 3) with n > 0, in [m].
        up: Direction that points upward, shape (3,).
        view: From a raised corner ("perspective"), or from the top, the front or a side.
        size: Width and height of the picture in [pixel].
        margin: Empty margins at both sides, and above and below (for the title), as fractions of
            the picture.
        angles: Of a perspective view; the usual ones when left out.

    Raises:
        ValueError: If there is no point, or a point is not finite.
    """
    cloud = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    if len(cloud) == 0 or not np.isfinite(cloud).all():
        raise ValueError(f"a camera needs at least one point, all finite; got {len(cloud)} points")
    upward = _unit(np.asarray(up, dtype=np.float64))
    toward, screen_up = _line_of_sight(cloud, upward, view, angles)
    fov = float(WIDE if view == "perspective" else NARROW)
    slopes = (1.0 - 2.0 * np.array(margin)) * np.tan(0.5 * fov) * np.array([size[0] / size[1], 1.0])
    axes = Camera(toward, np.zeros(3), screen_up, fov).axes
    position = axes.T @ _nearest_pinhole(cloud @ axes.T, slopes)
    distance = float(np.max((cloud - position) @ axes[2]))
    return Camera(position, position + distance * axes[2], screen_up, fov)


def _line_of_sight(
    cloud: Array, up: Array, view: View, angles: Angles | None
) -> tuple[Array, Array]:
    """The unit vectors from the scene to the viewer, and upward in the picture."""
    across, toward = horizontal_axes(up)
    if view == "top":
        return up, -toward
    if view == "front":
        return toward, up
    if view == "side":
        return across, up
    azimuth = -AZIMUTH if angles is None else angles.azimuth
    elevation = usual_elevation(cloud, up) if angles is None else angles.elevation
    straight_down = abs(np.cos(elevation)) < 1e-3
    level = to_viewer(up, azimuth, 0.0)
    return to_viewer(up, azimuth, elevation), -level if straight_down else up


def to_viewer(up: Array, azimuth: float | Array, elevation: float | Array) -> Array:
    """Unit vectors from the scene to a viewer, shape (3,), or (n, 3) of angles (n, 1) in [rad]."""
    across, toward = horizontal_axes(up)
    level = np.cos(azimuth) * toward + np.sin(azimuth) * across
    return np.asarray(np.cos(elevation) * level + np.sin(elevation) * up)


def usual_elevation(cloud: Array, up: ArrayLike) -> float:
    """Elevation in [rad] for points (n, 3): steep over a flat scene, where walls hide the floor."""
    upward = _unit(np.asarray(up, dtype=np.float64))
    extent = np.ptp(cloud @ np.stack([*horizontal_axes(upward), upward]).T, axis=0)
    slenderness = extent[2] / max(extent[0], extent[1], 1e-12)
    return float(np.interp(slenderness, [0.25, 0.8], [FLAT, TALL]))


def _nearest_pinhole(seen: Array, slopes: Array) -> Array:
    """The nearest pinhole, in camera axes, from which |x| <= slope z holds for all points.

    A point's two conditions per axis are linear in the pinhole's position (c, d): ``c - slope d >=
    x - slope z`` and ``-c - slope d >= -x - slope z``; their sum bounds d.
    """
    seen = np.where(np.abs(seen) < 1e-12, 0.0, seen)
    right = np.max(seen[:, :2] - slopes * seen[:, 2:], axis=0)
    left = np.max(-seen[:, :2] - slopes * seen[:, 2:], axis=0)
    depth = float(np.min(-(right + left) / (2.0 * slopes)))
    nearest = float(np.min(seen[:, 2]))
    extent = float(np.ptp(seen, axis=0).max())
    room = 0.05 * extent if extent > 0.0 else 1.0  # a single point is viewed from 1 m
    return np.array([*(right - left) / 2.0, min(depth, nearest - room)])


def _unit(vector: Array) -> Array:
    return vector / np.linalg.norm(vector)
