"""When frames are taken and where the machine is then."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.show.film.staging.timing import (
    MAX_FRAMES,
    interpolate_lines,
    interpolate_poses,
    schedule,
)
from kinolab.show.scene.models.rotor import whirled


def pose(angle: float, x: float = 0.0) -> np.ndarray:
    """Turned about z, moved along x."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0, x], [s, c, 0, 0], [0, 0, 1, 0]], dtype=float).reshape(12)


def motion(*rows: np.ndarray) -> np.ndarray:
    return np.stack(rows)[:, None]


def test_half_a_quarter_turn_is_an_eighth_turn() -> None:
    poses = motion(pose(0.0), pose(np.pi / 2, 2.0))
    found = interpolate_poses(np.array([0.0, 1.0]), poses, np.array([0.5]))
    assert found[0, 0] == pytest.approx(pose(np.pi / 4, 1.0))


def test_a_spinning_disk_turns_evenly_between_coarse_rows() -> None:
    """12 rad/s in rows of 0.05 s, seen every 0.04 s, over several full turns."""
    times = np.linspace(0.0, 3.0, 61)
    at = np.arange(0.0, 3.0, 0.04)
    found = interpolate_poses(times, motion(*(pose(12.0 * t) for t in times)), at)
    expected = np.stack([pose(12.0 * t) for t in at])
    assert found[:, 0] == pytest.approx(expected, abs=1e-12)  # rounding


@pytest.mark.parametrize("seed", range(5))
def test_interpolated_rotations_are_rotations_and_rows_are_met(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turns = np.linalg.qr(rng.normal(size=(12, 3, 3)))[0]
    turns *= np.linalg.det(turns)[:, None, None]
    poses = np.concatenate([turns, rng.normal(size=(12, 3, 1))], axis=2).reshape(6, 2, 12)
    times = np.sort(rng.uniform(0, 1, 6))
    R = interpolate_poses(times, poses, np.linspace(times[0], times[-1], 40))
    R = R.reshape(-1, 3, 4)[:, :, :3]
    assert R @ R.transpose(0, 2, 1) == pytest.approx(np.tile(np.eye(3), (80, 1, 1)), abs=1e-12)
    assert np.linalg.det(R) == pytest.approx(np.ones(80))
    assert interpolate_poses(times, poses, times) == pytest.approx(poses, abs=1e-12)


def test_two_rows_of_equal_time_are_a_jump() -> None:
    poses = motion(pose(0.0, 0.0), pose(0.0, 1.0), pose(0.0, 5.0), pose(0.0, 6.0))
    times = np.array([0.0, 1.0, 1.0, 2.0])
    found = interpolate_poses(times, poses, np.array([0.5, 1.0, 1.5]))
    assert found[:, 0, 3] == pytest.approx([0.5, 5.0, 5.5])


def test_cables_are_interpolated_on_lines() -> None:
    lines = np.zeros((2, 1, 2, 3))
    lines[1] = 4.0
    found = interpolate_lines(np.array([0.0, 2.0]), lines, np.array([0.5]))
    assert found == pytest.approx(np.ones((1, 1, 2, 3)))


def test_a_film_at_25_fps_has_a_frame_every_40_ms_and_ends_with_the_motion() -> None:
    film = schedule(1.0, 3.0)
    assert film.delay == 4
    assert film.times[:3] == pytest.approx([1.0, 1.04, 1.08])
    assert film.times[-1] == 3.0
    assert len(film.times) == 51


@pytest.mark.parametrize(("fps", "delay"), [(50, 2), (30, 3), (10, 10), (200, 2)])
def test_delays_are_whole_hundredths_that_viewers_respect(fps: float, delay: int) -> None:
    assert schedule(0.0, 1.0, fps).delay == delay


@pytest.mark.parametrize("duration", [15.97, 16.0, 60.0, 1234.5])
def test_a_long_motion_is_shown_faster(duration: float) -> None:
    film = schedule(0.0, duration)
    assert len(film.times) <= MAX_FRAMES
    assert film.speed * 2.0 == round(film.speed * 2.0)
    assert film.speed > 1.0
    assert np.diff(film.times)[:-1] == pytest.approx(film.speed * film.delay / 100.0)


def test_a_motion_of_no_duration_is_one_frame() -> None:
    assert schedule(2.0, 2.0).times == pytest.approx([2.0])


@pytest.mark.parametrize("rates", [(1.0, 0.0, 25, 1), (0.0, 1.0, 0, 1), (0.0, 1.0, 25, -1)])
def test_an_impossible_film_is_refused(rates: tuple[float, float, float, float]) -> None:
    with pytest.raises(ValueError, match="a film needs"):
        schedule(*rates)


def test_a_rotor_whirls_about_its_own_axis_and_nothing_else_moves() -> None:
    """10 rad/s of film in frames of 0.04 s, on top of the pose that the motion gives it."""
    still, tilted = pose(0.3, 1.0), pose(0.0, 2.0).reshape(3, 4)[:, [1, 2, 0, 3]].reshape(12)
    poses = np.stack([[still, tilted]] * 5)
    found = whirled(poses, (0.0, 10.0), 0.04)
    assert found[:, 0] == pytest.approx(poses[:, 0])
    for k, frame in enumerate(found[:, 1]):
        turned = tilted.reshape(3, 4).copy()
        turned[:, :3] = turned[:, :3] @ pose(0.4 * k).reshape(3, 4)[:, :3]
        assert frame.reshape(3, 4) == pytest.approx(turned, abs=1e-15)
