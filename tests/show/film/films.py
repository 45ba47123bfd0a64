"""From a motion to a film that can be drawn, and to a file: what a run does, without one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from kinolab.files import whole_file
from kinolab.show.film.film import Film, staged
from kinolab.show.film.gif import gif_parts
from kinolab.show.film.staging.script_writing import write_script
from kinolab.show.scene.picture import Picture, Surface
from kinolab.world.obstacles.obstacle import box_obstacle


def box_surface(
    name: str, edges: tuple[float, float, float], position: tuple[float, float, float]
) -> Surface:
    """A box as it is drawn."""
    box = box_obstacle(name, edges, position)
    return Surface(name, box.vertices, box.faces)


def make_film(picture: Picture, times: ArrayLike, poses: ArrayLike, **options: Any) -> Film:
    """Make the film of a motion.

    Args:
        picture: The picture to draw.
        times: Row times in [s], shape (nt,), not decreasing.
        poses: One pose per row and body, shape (nt, nb, 12).
        options: As those of ``write_script``.

    Raises:
        ValueError: If shapes are inconsistent, values are not finite, or times decrease.
    """
    return staged(write_script(picture, times, poses, **options))


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
        file.writelines(gif_parts(film))
