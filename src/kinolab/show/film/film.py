"""Frames of a motion with title and time stamp, independent of the file format."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import repeat

from kinolab.numerics.arrays import Array, Bytes
from kinolab.show.film.staging.inset import Inset
from kinolab.show.film.staging.inset_place import build_inset, whole_window
from kinolab.show.film.staging.script import Script
from kinolab.show.film.staging.stage import Stage, build_stage
from kinolab.show.film.staging.text import letter, time_stamp

RUN = 8  # frames that are prepared at once


@dataclass(frozen=True, eq=False)
class Film:
    """A motion ready to be rendered.

    Args:
        script: What is shown, and when.
        magnifier: Inset that enlarges the machine in a corner, if any; one without a frame is the
            whole picture, which goes with the machine.
    """

    script: Script
    stage: Stage
    magnifier: Inset | None = None

    def __len__(self) -> int:
        """The number of frames."""
        return len(self.script.poses)

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
        script, still = self.script, self.stage.still
        poses, lines, axes = (None if each is None else each[run] for each in script.moving)
        assert poses is not None
        window = None if self.magnifier is None or self.magnifier.framed else self.magnifier
        images = (window.views if window else self._whole)(poses, lines, axes)
        around = still.around if window else None
        for time, image in zip(script.playback.times[run], images, strict=False):
            stamp = time_stamp(float(time), script.playback.speed)
            letter(image, script.title, stamp, still.words, around)
            yield image

    def _whole(self, poses: Array, lines: Array | None, axes: Array | None) -> Iterator[Bytes]:
        """Draw the scene with its signs and its inset, if any."""
        inset = self.magnifier
        views = repeat(None) if inset is None else inset.views(poses, lines, axes)
        for image, view in zip(self.stage.shots(poses, lines, axes), views, strict=False):
            self.stage.signs.on(image)
            if inset is not None and view is not None:
                left, top, right, bottom = inset.box
                image[top:bottom, left:right] = view
            yield image


def staged(script: Script) -> Film:
    """Build the scene of a film, which can then be drawn."""
    stage = build_stage(script.picture, script.motion, script.size)
    inset = whole_window(stage, script) if script.picture.follow else None
    if inset is None and script.magnify:
        inset = build_inset(stage, script)
    return Film(script, stage, inset)
