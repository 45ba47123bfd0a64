"""A single rendered frame of a machine."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.show.film.picture import Picture, pose_table
from kinolab.show.film.staging.stage import build_scene
from kinolab.show.film.text import letter, time_stamp


def render_frame(
    picture: Picture,
    poses: ArrayLike,
    time: float = 0.0,
    *,
    size: tuple[int, int] = (800, 600),
    title: str = "",
    lines: ArrayLike | None = None,
) -> NDArray[np.uint8]:
    """Render the machine at given poses.

    Args:
        picture: The picture to draw.
        poses: One pose per body, shape (nb, 12).
        time: For the time stamp and for a picture whose ``lines`` is a function, in [s].
        size: Width and height in [pixel].
        title: One line of text.
        lines: Cables at this time, shape (nl, 2, 3), if ``picture.lines`` is an array.

    Returns:
        RGB pixels, shape (h, w, 3).
    """
    table = pose_table(poses)
    cables = picture.lines(time) if callable(picture.lines) else lines
    segments = None if cables is None else np.asarray(cables, dtype=np.float64)
    scene = build_scene(picture, table[None], size)
    image = scene.shot(table, segments)
    scene.signs.on(image)
    letter(image, title, time_stamp(time), scene.still.words)
    return image
