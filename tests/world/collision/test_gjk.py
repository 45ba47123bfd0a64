from __future__ import annotations

import numpy as np
import pytest

from kinolab.world.distances.gjk import TRIANGLE, Convex, separation

UPRIGHT, UNUSED = np.eye(3), np.ones(3)


def triangle(
    *corners: tuple[float, float, float],
) -> Convex:
    points = np.array(corners, dtype=float)
    return Convex(TRIANGLE, UNUSED, np.ascontiguousarray(points.T), points[0])


def sphere(radius: float, *at: float) -> Convex:
    return Convex(1, np.full(3, radius), UPRIGHT, np.array(at, dtype=float))


FLOOR = triangle((0, 0, 0), (1, 0, 0), (0, 1, 0))


@pytest.mark.parametrize(
    ("at", "distance"),
    [
        ((0.2, 0.2, 0.5), 0.5),  # above the face
        ((0.5, -0.3, 0.4), 0.5),  # beside the edge y = 0
        ((1.0, 1.0, 0.0), np.sqrt(0.5)),  # beside the hypotenuse
        ((-3.0, -4.0, 12.0), 13.0),  # beyond a corner
        ((0.2, 0.2, 1e-6), 1e-6),
    ],
)
def test_a_point_is_as_far_from_a_triangle_as_drawn(
    at: tuple[float, float, float], distance: float
) -> None:
    assert separation(sphere(0.0, *at), FLOOR) == pytest.approx(distance, abs=2e-9)  # [m]
    assert separation(FLOOR, sphere(0.0, *at)) == pytest.approx(distance, abs=2e-9)


@pytest.mark.parametrize("thin", [1e-3, 1e-6, 1e-12, 0.0])
def test_slivers_still_give_a_valid_bound(thin: float) -> None:
    sliver = triangle((-1, 0, 0), (1, 0, 0), (0, thin, 0))
    bound = separation(sphere(0.1, 0.1, 0.0, 1.0), sliver)
    assert 0.9 - 1e-6 <= bound <= 0.9 + 1e-12  # [m]


def test_nothing_is_proved_for_things_that_overlap() -> None:
    assert separation(sphere(0.5, 0, 0, 0), sphere(0.5, 0.9, 0, 0)) == 0.0
    assert separation(sphere(0.5, 0, 0, 0), sphere(0.5, 0, 0, 0)) == 0.0
