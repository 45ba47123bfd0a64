"""What is tiny in a picture is shown enlarged in a corner, as the same camera sees it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinolab.dynamics.facts.machine_facts import BodyGeometry
from kinolab.dynamics.language.shapes import Box, Sphere
from kinolab.show.film.staging.inset import Inset
from kinolab.show.scene.picture import Picture
from tests.show.film.films import box_surface, make_film

SIZE = (600, 450)
RED, BLUE = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
LONG = {"x": (-10.0, 10.0), "y": (-2.0, 2.0)}
PAIR = [
    BodyGeometry("red", (Sphere(0.1),), color=RED),
    BodyGeometry("blue", (Box(0.1, 0.1, 0.1),), color=BLUE),
]


def pair_at(x: float, y: float) -> np.ndarray:
    """Two bodies, 0.3 m apart, shape (2, 12)."""
    places = [(x, y, 0.1), (x + 0.3, y, 0.1)]
    return np.stack([np.column_stack([np.eye(3), place]).reshape(12) for place in places])


def of_colour(image: np.ndarray, channel: int) -> np.ndarray:
    """Columns and rows where one channel is the strongest by far, shape (n, 2)."""
    others = np.delete(image.astype(int), channel, axis=-1).max(axis=-1)
    return np.argwhere(image[..., channel].astype(int) > others + 60)[:, ::-1]


def filmed(picture: Picture, poses: np.ndarray) -> tuple[np.ndarray, Inset | None]:
    """The last frame, and what enlarged a part of it."""
    times = np.linspace(0.0, 1.0, len(poses))
    film = make_film(picture, times, poses, size=SIZE, fps=2.0, magnify=True)
    return film.frame(len(film) - 1), film.magnifier


@pytest.mark.parametrize("x", [-9.0, 0.0, 8.5])
def test_the_enlarged_part_is_the_same_view_with_more_pixels(x: float) -> None:
    picture = Picture(bodies=PAIR, ground=True, bounds=LONG)
    image, magnifier = filmed(picture, np.stack([pair_at(x - 0.2, 0.3), pair_at(x, 0.3)]))
    assert magnifier is not None
    left, top, right, bottom = magnifier.box
    part, rest = image[top:bottom, left:right], image.copy()
    rest[top:bottom, left:right] = 250
    red, blue = of_colour(part, 0), of_colour(part, 2)
    assert len(red) == pytest.approx(magnifier.times**2 * len(of_colour(rest, 0)), rel=0.35)
    middle = np.array([right - left, bottom - top]) / 2
    both = (red.mean(axis=0) + blue.mean(axis=0)) / 2
    assert np.abs(both - middle).max() < 0.1 * (bottom - top)
    small = of_colour(rest, 2).mean(axis=0) - of_colour(rest, 0).mean(axis=0)
    large = blue.mean(axis=0) - red.mean(axis=0)
    assert large == pytest.approx(magnifier.times * small, abs=magnifier.times)  # a small pixel


def test_nothing_of_the_world_is_covered() -> None:
    picture = Picture(bodies=PAIR, ground=True, bounds=LONG)
    poses = np.stack([pair_at(x, 0.0) for x in np.linspace(-9, 9, 20)])
    image, magnifier = filmed(picture, poses)
    assert magnifier is not None
    film = make_film(picture, np.linspace(0.0, 1.0, 20), poses, size=SIZE, fps=2.0)
    assert film.magnifier is None
    left, top, right, bottom = magnifier.box
    bare = film.frame(len(film) - 1)
    assert (bare[top:bottom, left:right] == bare[-1, 0]).all(axis=-1).mean() > 0.97  # paper
    outside = np.ones(SIZE[::-1], dtype=bool)
    outside[top:bottom, left:right] = False
    assert (bare[outside] == image[outside]).all()


def test_the_machine_shows_through_a_wall_in_the_enlarged_part_too() -> None:
    wall = box_surface("wall", (2.0, 0.1, 2.0), (0.15, -0.6, 1.0))
    picture = Picture(bodies=PAIR, obstacles=[wall], ground=True, bounds=LONG, view="front")
    image, magnifier = filmed(picture, np.stack([pair_at(-4.0, 0.0), pair_at(0.0, 0.0)]))
    assert magnifier is not None
    left, top, right, bottom = magnifier.box
    assert len(of_colour(image[top:bottom, left:right], 0)) > 20


def test_what_is_large_is_not_enlarged_and_neither_where_there_is_no_room() -> None:
    poses = np.stack([pair_at(-0.3, 0.0), pair_at(0.0, 0.0)])
    small = {"x": (-0.5, 0.5), "y": (-0.5, 0.5)}
    assert filmed(Picture(bodies=PAIR, ground=True, bounds=small), poses)[1] is None
    square = {"x": (-9.0, 9.0), "y": (-7.5, 7.5)}
    everywhere = Picture(bodies=PAIR, ground=True, bounds=square, view="top")
    assert filmed(everywhere, poses)[1] is None


@pytest.mark.parametrize("x", [-8.0, 0.0, 8.0])
def test_a_film_that_goes_with_the_machine_has_it_in_the_middle_and_large(x: float) -> None:
    picture = Picture(bodies=PAIR, ground=True, bounds=LONG, follow=True)
    poses = np.stack([pair_at(-9.0, 0.0), pair_at(x, 0.5)])
    followed = make_film(picture, np.linspace(0.0, 1.0, 2), poses, size=SIZE, fps=2.0)
    resting, _ = filmed(replace(picture, follow=False), poses)
    image = followed.frame(len(followed) - 1)
    near = np.concatenate([of_colour(image, channel) for channel in (0, 2)])
    far = np.concatenate([of_colour(resting, channel) for channel in (0, 2)])
    assert near.mean(axis=0) / SIZE == pytest.approx([0.5, 0.5], abs=0.06)
    assert np.ptp(near[:, 0]) > 0.15 * SIZE[0]
    assert len(near) > len(far)
