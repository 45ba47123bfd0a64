"""Frames of a motion with title and time stamp, independent of the file format."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.show.film.inset import Inset
from kinolab.show.film.scene import Scene
from kinolab.show.film.text import letter, time_stamp

Bytes: TypeAlias = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Playback:
    """Sample times of the frames, and their display rate.

    Args:
        times: In [s], shape (nf,), from the start to the end of the motion.
        period: Duration of a frame, in [s].
        speed: Seconds of motion per second of film.
    """

    times: Array
    period: float
    speed: float

    @property
    def delay(self) -> int:
        """Duration of a frame, in [1/100 s]."""
        return round(100.0 * self.period)


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
        letter(image, self.title, stamp)
        return image

    def frames(self) -> Iterator[Bytes]:
        """All frames in order, rendered lazily."""
        return (self.frame(i) for i in range(len(self)))
