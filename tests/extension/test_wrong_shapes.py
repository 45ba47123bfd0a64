"""A shape from outside that is not a solid, or is not what it says, is refused with its name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from kinolab.dynamics import Body, System, length, move, parameter
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.dynamics.language.shapes import ORIGIN, Hull, Point, Shape
from kinolab.dynamics.language.shapes.packed_rows import packed
from kinolab.errors import InputError
from kinolab.numerics.arrays import Array
from kinolab.world.shapes.geometry import triangles

CORNERS = np.array([[x, y, z] for x in (-0.3, 0.3) for y in (-0.2, 0.2) for z in (-0.1, 0.1)])
EAST = np.array([1.0, 0.0, 0.0])


def farthest(directions: Array, corners: Array = CORNERS) -> Array:
    found: Array = corners[(directions @ corners.T).argmax(axis=1)]
    return found


@dataclass(frozen=True)
class Brick(Shape):
    """A brick by its corners; what it says of itself is given."""

    answer: Any = None
    symmetric: str = ""
    at: Point = ORIGIN

    def lengths(self) -> list[str]:
        """Have none."""
        return []

    def support(self, directions: Array) -> Array:
        """Return what the answer makes of the directions."""
        found: Array = (self.answer or farthest)(directions)
        return found


@dataclass
class Soft(Shape):
    """It can be changed."""

    at: Point = ORIGIN

    def support(self, directions: Array) -> Array:
        """Return corners."""
        return farthest(directions)


class Plain(Shape):
    """It is not a dataclass."""

    def support(self, directions: Array) -> Array:
        """Return corners."""
        return farthest(directions)


def moved(shape: Shape) -> System:
    return System("block", bodies=[Body("block", move(length("x")), mass=1.0, shape=shape)])


def raises(_: Array) -> Array:
    raise KeyError("rim")


HULL = "shape Brick: no hull around it can be made: "
ANSWERS: dict[str, Callable[[Array], Any]] = {
    f"{HULL}support(…) returned nan.": lambda n: farthest(n) * np.nan,
    f"{HULL}support(…) returned inf.": lambda n: farthest(n) + np.inf,
    f"{HULL}support(…) returned the shape (3, 26), expected (26, 3).": lambda n: farthest(n).T,
    f"{HULL}support(…) returned the shape (26,), expected (26, 3).": lambda n: n[:, 0],
    f"{HULL}support(…) failed (KeyError: 'rim').": raises,
    f"{HULL}n.p is -0.353553 m along (-0.707, -0.707, 0), so": lambda n: farthest(-n),
    f"{HULL}n.p is -0.7 m along (-1, 0, 0), so p is not the": lambda n: farthest(n) + EAST,
    f"{HULL}it is flat along n = (0, 0, -1).": lambda n: farthest(n) * [1, 1, 0],
    "and that of (": lambda n: farthest(n) * np.where(n[:, :1] > 0.9, 0.5, 1.0),
}


@pytest.mark.parametrize("said", ANSWERS)
def test_points_that_are_not_the_farthest_are_refused(said: str) -> None:
    with pytest.raises(InputError) as caught:
        moved(Brick(ANSWERS[said]))
    assert said in str(caught.value)
    assert str(caught.value).endswith(
        "Let support(…) return, for each unit vector n, the point p with the largest n.p."
    )


@pytest.mark.parametrize(
    ("symmetric", "said"),
    [
        ("y", 'symmetric is \'y\', and can be "", "z" or "xyz".'),
        ("z", 'symmetric is "z", but it reaches 0.2 m along n = (0, '),
        ("xyz", 'symmetric is "xyz", but it reaches '),
    ],
)
def test_what_is_not_as_round_as_it_says_is_refused(symmetric: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        moved(Brick(symmetric=symmetric))
    assert said.partition("(0, ")[0] in str(caught.value)


def test_what_is_nearly_round_is_refused_as_well() -> None:
    """A prism of 32 sides turns noticeably, by half a percent of its radius."""
    turns = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    rim = np.column_stack([np.cos(turns), np.sin(turns), np.ones(32)])
    prism = np.concatenate([rim, rim * [1, 1, -1]])
    with pytest.raises(InputError, match='symmetric is "z", but it reaches'):
        moved(Brick(lambda n: farthest(n, prism), "z"))


MISTAKES: dict[str, Callable[[], Shape]] = {
    "class Soft: it can be changed (unhashable type: 'Soft'). Write @dataclass(frozen=True)": Soft,
    "class Plain: it is not a dataclass with a field at. Write @dataclass(frozen=True)": Plain,
    "body 'block' brick: at is (0, 0). Give three numbers (x, y, z) in [m].": lambda: Brick(
        at=(0, 0)  # type: ignore[arg-type]
    ),
    "body 'block' brick: at is [0, 0, 0]. Give three numbers": lambda: Brick(
        at=[0, 0, 0]  # type: ignore[arg-type]
    ),
}


@pytest.mark.parametrize("said", MISTAKES)
def test_a_class_that_is_not_a_frozen_dataclass_with_a_place_is_refused(said: str) -> None:
    with pytest.raises(InputError) as caught:
        moved(MISTAKES[said]())
    assert said in str(caught.value)


def test_a_list_of_points_will_do() -> None:
    (hull,) = moved(Brick(lambda n: farthest(n).tolist())).resolved_shapes(moved(Brick()).bodies[0])
    np.testing.assert_allclose(triangles(hull)[0].max(axis=0), [0.3, 0.2, 0.1], rtol=1e-12)


FILES: dict[str, dict[str, Any]] = {
    "it does not hold its centre": {"points": packed(CORNERS + EAST, "<f8")},
    "no hull around it can be made": {"points": packed(CORNERS * [1, 1, 0], "<f8")},
    'symmetric is "z", but it reaches': {"symmetric": "z"},
    "a corner is nan m away": {"points": packed(CORNERS * np.nan, "<f8")},
    "a corner is 3e+09 m away": {"points": packed(CORNERS * 1e10, "<f8")},
    "Incorrect padding": {"points": "abc"},
    "it was made for r = 2, and r is 3": {"made_for": ((parameter("r", 3.0), 2.0),)},
}


@pytest.mark.parametrize("said", FILES)
def test_a_file_with_other_points_is_refused(said: str) -> None:
    good = Hull("Brick", packed(CORNERS, "<f8"))
    text = machine_to_json(moved(good))
    assert machine_from_json(text).bodies[0].shapes == (good,)
    with pytest.raises(InputError) as caught:
        moved(Hull(**{"name": "Brick", "points": good.points} | FILES[said]))
    assert said in str(caught.value)
