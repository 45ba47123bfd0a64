"""Frames of a motion with title and time stamp, independent of the file format."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import repeat
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.show.film.inset import Inset
from kinolab.show.film.scene import Scene
from kinolab.show.film.staging.playback import Playback
from kinolab.show.film.text import letter, time_stamp
from kinolab.show.film.travelling import Travelling

Bytes: TypeAlias = NDArray[np.uint8]

RUN = 8  # frames that are prepared at once


@dataclass(frozen=True, eq=False)
class Film:
    """A motion ready to be rendered.

    Args:
        stage: The scene and its camera, which may go with the machine.
        playback: Times of the frames; ``nf`` is their number.
        poses: Shape (nf, nb, 12).
        lines: Cables, shape (nf, nl, 2, 3), or None.
        title: One line of text.
        magnifier: Inset that enlarges the machine in a corner, if any.
    """

    stage: Scene | Travelling
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
        return next(self.shots(slice(i, i + 1)))

    def frames(self) -> Iterator[Bytes]:
        """All frames in order, rendered lazily."""
        return (image for run in self.runs() for image in self.shots(run))

    def runs(self) -> list[slice]:
        """Frames that follow each other, which are drawn in one go."""
        return [slice(i, min(i + RUN, len(self))) for i in range(0, len(self), RUN)]

    def shots(self, run: slice) -> Iterator[Bytes]:
        """Draw some frames: RGB pixels, shape (h, w, 3) each."""
        poses, lines = self.poses[run], None if self.lines is None else self.lines[run]
        views = repeat(None) if self.magnifier is None else self.magnifier.views(poses, lines)
        words = self.stage.still.words
        shots = zip(self.playback.times[run], self.stage.shots(poses, lines), views, strict=False)
        for time, image, view in shots:
            self.stage.signs.on(image)
            if self.magnifier is not None and view is not None:
                self.magnifier.put(view, image)
            stamp = time_stamp(float(time), self.playback.speed)
            letter(image, self.title, stamp, words, self.stage.around)
            yield image
