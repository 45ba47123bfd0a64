"""Where points land in the picture."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.show.scene.camera import Camera, View, frame_scene

SIZE = (800, 600)
VIEWS: tuple[View, ...] = ("perspective", "top", "front", "side")


def test_a_point_lands_where_the_pinhole_law_says() -> None:
    """10 m in front of the pinhole, 1 m is focal length / 10 long."""
    camera = Camera(np.array([0.0, -10, 0]), np.zeros(3), np.array([0.0, 0, 1]), np.pi / 3)
    focal = 300.0 / np.tan(np.pi / 6)  # half the height over the tangent of half the angle
    column, row, depth = camera.project([1.0, 0.0, 2.0], SIZE)
    assert column == pytest.approx(400.0 + focal / 10.0)
    assert row == pytest.approx(300.0 - 2.0 * focal / 10.0)
    assert depth == pytest.approx(10.0)


def test_twice_as_far_is_half_as_large() -> None:
    camera = Camera(np.array([0.0, -10, 0]), np.zeros(3), np.array([0.0, 0, 1]), 0.5)
    near, far = camera.project([[1.0, 0.0, 0.0], [1.0, 10.0, 0.0]], SIZE)[:, 0] - 400.0
    assert near == pytest.approx(2.0 * far)


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("seed", range(5))
def test_a_framed_scene_lies_inside_the_picture_and_fills_it(view: View, seed: int) -> None:
    """No point leaves the margins, and the tighter direction touches both of its margins."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1, 1, (50, 3)) * rng.uniform(0.2, 20.0, 3) + rng.uniform(-50, 50, 3)
    camera = frame_scene(points, view=view, size=SIZE, margin=(0.1, 0.1))
    seen = camera.project(points, SIZE)
    low, high = seen[:, :2].min(axis=0), seen[:, :2].max(axis=0)
    assert (seen[:, 2] > 0.0).all()
    assert (low >= [80 - 1e-6, 60 - 1e-6]).all()  # [pixel]; margins of a tenth, and rounding
    assert (high <= [720 + 1e-6, 540 + 1e-6]).all()
    fills = (low < [80.01, 60.01]) & (high > [719.99, 539.99])
    assert fills.any()


def test_a_plan_shows_x_to_the_right_and_y_upward() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    origin, x, y = frame_scene(points, view="top").project(points, SIZE)[:, :2]
    assert x[0] > origin[0]
    assert x[1] == pytest.approx(origin[1])
    assert y[1] < origin[1]
    assert y[0] == pytest.approx(origin[0])


@pytest.mark.parametrize("view", ["perspective", "front", "side"])
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_up_is_up_in_the_picture(view: View, axis: int, sign: float) -> None:
    up = np.zeros(3)
    up[axis] = sign
    points = np.concatenate([np.eye(3), -np.eye(3)])
    rows = frame_scene(points, up, view).project([np.zeros(3), up], SIZE)[:, 1]
    assert rows[1] < rows[0] - 50.0  # [pixel]


def test_a_pendulum_drawn_with_x_downward_swings_to_the_right_along_y() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0]])
    pivot, hanging, right = frame_scene(points, (-1.0, 0.0, 0.0), "front").project(points, SIZE)
    assert hanging[1] > pivot[1] + 100.0  # [pixel]
    assert right[0] > hanging[0] + 100.0


def test_a_single_point_is_framed_and_none_is_refused() -> None:
    assert frame_scene([[1.0, 2.0, 3.0]]).project([1.0, 2.0, 3.0], SIZE)[2] > 0.0
    with pytest.raises(ValueError, match="at least one point"):
        frame_scene(np.zeros((0, 3)))
    with pytest.raises(ValueError, match="finite"):
        frame_scene([[np.nan, 0.0, 0.0]])
