"""What a film shows, and when: plain data, for whoever draws it."""

from __future__ import annotations

from dataclasses import dataclass

from kinolab.numerics.arrays import Array
from kinolab.show.film.picture import Picture
from kinolab.show.film.staging.playback import Playback


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
    """

    picture: Picture
    motion: Array
    playback: Playback
    poses: Array
    lines: Array | None
    size: tuple[int, int]
    title: str = ""
    magnify: bool = False
