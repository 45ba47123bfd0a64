"""Frames of a motion with title and time stamp, independent of the file format."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.numerics.arrays import Array
from kinolab.show.film.inset import Inset, build_inset
from kinolab.show.film.models.rotor import whirled
from kinolab.show.film.picture import Picture
from kinolab.show.film.scene import Scene, build_scene, pose_table
from kinolab.show.film.text import lettered, time_stamp
from kinolab.show.film.timing import Playback, interpolate_lines, interpolate_poses, schedule

Bytes: TypeAlias = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Film:
    """A motion ready to be rendered.

    Args:
        stage: The scene and its camera.
        playback: Times of the frames; ``nf`` is their number.
        poses: Shape (nf, nb, 12).
        lines: Cables, shape (nf, nl, 2, 3), or None.
        title: One line of text.
        magnifier: Inset that enlarges the machine in a corner, if any.
    """

    stage: Scene
    playback: Playback
    poses: Array
    lines: Array | None
    title: str
    magnifier: Inset | None = None

    def __len__(self) -> int:
        """The number of frames."""
        return len(self.poses)

    def frame(self, i: int) -> Bytes:
        """RGB pixels of frame ``i``, shape (h, w, 3)."""
        lines = None if self.lines is None else self.lines[i]
        image = self.stage.shot(self.poses[i], lines)
        if self.magnifier is not None:
            self.magnifier.put(image, self.poses[i], lines)
        stamp = time_stamp(float(self.playback.times[i]), self.playback.speed)
        return lettered(image, self.title, stamp)

    def frames(self) -> Iterator[Bytes]:
        """All frames in order, rendered lazily."""
        return (self.frame(i) for i in range(len(self)))


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
