"""From a motion to the script of a film: frames at even times, and poses in between rows."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.scenario.schema import RenderSection
from kinolab.show.film.staging.script import Script
from kinolab.show.film.staging.timing import interpolate_lines, interpolate_poses, schedule
from kinolab.show.scene.models.rotor import whirled
from kinolab.show.scene.picture import Picture
from kinolab.show.scene.problem_picture import picture
from kinolab.trajectory import Trajectory


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


def write_script(
    shown: Picture,
    times: ArrayLike,
    poses: ArrayLike,
    *,
    size: tuple[int, int] = (800, 600),
    fps: float = 25.0,
    speed: float = 1.0,
    title: str = "",
    video: bool = False,
    magnify: bool = False,
) -> Script:
    """Resample a motion to frames; a video may have more of them than a GIF.

    Args:
        shown: The picture to draw.
        times: Row times in [s], shape (nt,), not decreasing.
        poses: One pose per row and body, shape (nt, nb, 12) or (nt, nb, 3, 4).
        size: Width and height in [pixel].
        fps: Frames per second of film.
        speed: Seconds of motion per second of film.
        title: One line of text.
        video: Whether it may be long.
        magnify: Whether a tiny machine is also shown enlarged in a free corner.

    Raises:
        ValueError: If shapes are inconsistent, values are not finite, or times decrease.
    """
    t, table = np.asarray(times, dtype=np.float64), np.asarray(poses, dtype=np.float64)
    if table.ndim == 4:
        table = table.reshape(*table.shape[:2], 12)
    _check(t, table, len(shown.bodies))
    playback = schedule(float(t[0]), float(t[-1]), fps, speed, video=video)
    motion, axes = table, None if shown.frames is None else shown.frames.poses
    if len(t) == 1:
        t, table = np.repeat(t, 2), np.repeat(table, 2, axis=0)
        axes = None if axes is None else np.repeat(axes, 2, axis=0)
    moved = interpolate_poses(t, table, playback.times)
    moved = whirled(moved, [body.whirl for body in shown.bodies], playback.period)
    cables = shown.lines
    if cables is not None:
        each = np.broadcast_to(cables, (len(t), *np.shape(cables)[1:]))  # or the same in all rows
        cables = interpolate_lines(t, each, playback.times)
    if axes is not None:
        axes = interpolate_poses(t, axes, playback.times)
    return Script(shown, motion, playback, moved, cables, size, title, magnify, axes)


def _check(times: Array, poses: Array, bodies: int) -> None:
    if poses.shape != (len(times), bodies, 12) or len(times) == 0:
        raise ValueError(
            f"{len(times)} times and {bodies} bodies need poses of shape "
            f"({len(times)}, {bodies}, 12), at least one row; got {poses.shape}"
        )
    if not (np.isfinite(times).all() and np.isfinite(poses).all()):
        raise ValueError("a motion that is shown must be finite; found NaN or infinity")
    if (np.diff(times) < 0.0).any():
        raise ValueError("times must not decrease")
