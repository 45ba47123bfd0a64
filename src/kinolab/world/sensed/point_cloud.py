"""Clouds of points as obstacles: a ball around each of them, all in one search tree."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.untrusted import refuse_many
from kinolab.world.meshes.mesh import check
from kinolab.world.meshes.mesh_components import Components
from kinolab.world.meshes.mesh_hints import MAX_EXTENT
from kinolab.world.meshes.mesh_reading import refusal
from kinolab.world.obstacles.obstacle import ORIGIN, Numbers, Obstacle, placed, upright
from kinolab.world.sensed.cloud_file import read_cloud


def cloud_obstacle(
    name: str,
    path: str,
    root: Path,
    position: Numbers = ORIGIN,
    rpy: Numbers = ORIGIN,
    *,
    radius: float,
    voxel: float | None = None,
    scale: float | Numbers = 1.0,
    up: Literal["x", "y", "z"] = "z",
) -> Obstacle:
    """Read a cloud and put a ball around each of its points.

    Args:
        name: What the user calls it in reports.
        path: The file, looked up from ``root``, which it may not leave.
        position: Where the file's origin goes, [m].
        rpy: Roll, pitch, yaw in [rad].
        radius: Of the balls, in [m].
        voxel: Edge in [m] of cubes, in each of which all points become one; the radius grows.
        scale: One factor, or one per axis of the file.
        up: The axis of the file that points up.

    Raises:
        InputError: If the file is unusable, or has too many points.
    """
    read = read_cloud(path, root=root)
    sound = np.isfinite(read).all(axis=1)
    if not sound.any():
        what = "has no point whose coordinates are finite numbers."
        raise refusal(path, what, "Export it again.")
    pose = placed(name, position, rpy)
    points = read[sound] @ (pose[:, :3] @ upright(name, scale, up)).T + pose[:, 3]
    warnings = []
    if not sound.all():
        warnings.append(
            f"{path}: {np.count_nonzero(~sound)} of {len(read)} points are no finite numbers, as "
            "where a sensor saw nothing; they are left out."
        )
    extent = float(np.ptp(points, axis=0).max())
    if scale == 1.0 and extent > MAX_EXTENT:
        warnings.append(f"{path}: is {extent:.4g} m wide. Millimetres? Then write scale = 0.001.")
    told = f"balls of {radius:g} m around {len(points)} points"
    if voxel is not None:
        points, farthest = _merged(path, points, voxel)
        told += f", merged to {len(points)} of {radius + farthest:.6g} m, which cover them"
        radius += farthest
    remedy = "Write voxel = 0.05 [m], or a larger one, to merge near ones."
    refuse_many(len(points), "points", path, remedy)
    faces = np.repeat(np.arange(len(points))[:, None], 3, axis=1)
    check(path, points, faces)
    return Obstacle(
        name,
        points,
        faces,
        solid=False,
        source=(root / path).resolve(),
        warnings=tuple(warnings),
        parts=Components(np.zeros(len(points), np.int64), np.zeros(1)),
        told=told,
        ball=radius,
    )


def _merged(where: str, points: Array, voxel: float) -> tuple[Array, float]:
    """Merge the points (n, 3) in each cube into their mean; return the farthest that one moved."""
    cells = np.floor((points - points.min(axis=0)) / voxel)
    many = 2**20  # three numbers below fit into one of 64 bits
    if cells.max() >= many:
        what = f"is more than {many} times as wide as its voxel."
        raise refusal(where, what, "Write a larger voxel.")
    x, y, z = cells.astype(np.int64).T
    _, which, count = np.unique((x * many + y) * many + z, return_inverse=True, return_counts=True)
    sums = [np.bincount(which, weights=column) for column in points.T]
    means = np.column_stack(sums) / count[:, None]
    return means, float(np.linalg.norm(points - means[which], axis=1).max())
