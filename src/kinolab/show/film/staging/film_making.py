"""From a motion to a film, frames at even times and the scene they are drawn in; and to a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from kinolab.files import whole_file
from kinolab.numerics.arrays import Array
from kinolab.show.film.film import Film
from kinolab.show.film.gif import gif_parts
from kinolab.show.film.models.rotor import whirled
from kinolab.show.film.picture import Picture
from kinolab.show.film.scene import pose_table
from kinolab.show.film.staging.inset_place import build_inset
from kinolab.show.film.staging.stage import build_scene
from kinolab.show.film.staging.timing import interpolate_lines, interpolate_poses, schedule


def make_film(
    picture: Picture,
    times: ArrayLike,
    poses: ArrayLike,
    *,
    size: tuple[int, int] = (800, 600),
    fps: float = 25.0,
    speed: float = 1.0,
    title: str = "",
    video: bool = False,
    magnify: bool = False,
) -> Film:
    """Resample a motion to frames and build its scene; a video may have more frames than a GIF.

    Args:
        picture: The picture to draw.
        times: Row times in [s], shape (nt,), not decreasing.
        poses: One pose per row and body, shape (nt, nb, 12).
        size: Width and height in [pixel].
        fps: Frames per second of film.
        speed: Seconds of motion per second of film.
        title: One line of text.
        video: Whether it may be long.
        magnify: Whether a tiny machine is also shown enlarged in a free corner.

    Raises:
        ValueError: If shapes are inconsistent, values are not finite, or times decrease.
    """
    t, table = np.asarray(times, dtype=np.float64), pose_table(poses)
    _check(t, table, len(picture.bodies))
    playback = schedule(float(t[0]), float(t[-1]), fps, speed, video=video)
    stage = build_scene(picture, table, size)
    if len(t) == 1:
        t, table = np.repeat(t, 2), np.repeat(table, 2, axis=0)
    moved = interpolate_poses(t, table, playback.times)
    moved = whirled(moved, [body.whirl for body in picture.bodies], playback.period)
    magnifier = build_inset(picture, stage, moved, size) if magnify else None
    return Film(stage, playback, moved, _cables(picture, t, playback.times), title, magnifier)


def write_gif(
    path: Path | str,
    picture: Picture,
    times: ArrayLike,
    poses: ArrayLike,
    *,
    size: tuple[int, int] = (800, 600),
    fps: float = 25.0,
    speed: float = 1.0,
    title: str = "",
) -> None:
    """Render a motion to a GIF file, written atomically.

    Args:
        path: Where to write; an existing file is replaced.
        picture: The picture to draw.
        times: Row times in [s], shape (nt,), not decreasing.
        poses: One pose per row and body, shape (nt, nb, 12).
        size: Width and height in [pixel].
        fps: Frames per second of film; GIF can only show 100 / n of them for whole n.
        speed: Seconds of motion per second of film; raised if more than 400 frames were needed.
        title: One line of text.

    Raises:
        ValueError: If the motion is not finite, not in order, or does not fit the bodies.
        OSError: If the file cannot be written.
    """
    film = make_film(picture, times, poses, size=size, fps=fps, speed=speed, title=title)
    with whole_file(Path(path)) as file:
        file.writelines(gif_parts(film, size))


def _cables(picture: Picture, times: Array, at: Array) -> Array | None:
    if picture.lines is None:
        return None
    if callable(picture.lines):
        return np.stack([np.asarray(picture.lines(float(t)), dtype=np.float64) for t in at])
    lines = np.asarray(picture.lines, dtype=np.float64)
    if len(lines) == 1:
        lines = np.repeat(lines, len(times), axis=0)
    return interpolate_lines(times, lines, at)


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
