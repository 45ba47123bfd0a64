"""What a film shows, and when: plain data, for whoever draws it."""

from __future__ import annotations

from dataclasses import dataclass

from kinolab.numerics.arrays import Array
from kinolab.show.scene.picture import Picture


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
class Script:
    """A film that is not drawn yet.

    Args:
        picture: The picture to draw.
        motion: Poses that the camera must see, shape (nt, nb, 12).
        playback: Times of the frames; ``nf`` is their number.
        poses: Of the frames, shape (nf, nb, 12).
        lines: Cables, shape (nf, nl, 2, 3), or None.
        size: Width and height in [pixel].
        title: One line of text.
        magnify: Whether a tiny machine is also shown enlarged in a free corner.
        frames: Poses of the frames whose axes are drawn, shape (nf, n, 12), or None.
    """

    picture: Picture
    motion: Array
    playback: Playback
    poses: Array
    lines: Array | None
    size: tuple[int, int]
    title: str = ""
    magnify: bool = False
    frames: Array | None = None

    @property
    def moving(self) -> tuple[Array, Array | None, Array | None]:
        """What has a row for each frame of the film: bodies, cables, axes."""
        return self.poses, self.lines, self.frames
