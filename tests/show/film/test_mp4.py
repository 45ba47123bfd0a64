"""The film that a motion becomes, read back by its decoder."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.cli import run
from kinolab.errors import InputError
from kinolab.runs import write_run
from kinolab.show.film.animation import mp4
from tests.show.film.films import make_film
from tests.show.film.test_gif import PICTURE, rolling

av = pytest.importorskip("av")

SIZE = (200, 150)


def frames(content: bytes) -> list[np.ndarray]:
    with av.open(io.BytesIO(content)) as film:
        return [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]


@pytest.mark.parametrize(("duration", "fps"), [(1.0, 30.0), (0.5, 12.0), (0.4, 12.5)])
def test_a_film_has_its_frames_its_rate_and_a_second_at_the_end(
    duration: float, fps: float
) -> None:
    film = make_film(PICTURE, *rolling(duration), size=SIZE, fps=fps, video=True)
    content = mp4(film, fps)
    with av.open(io.BytesIO(content)) as file:
        (stream,) = file.streams.video
        assert (stream.width, stream.height) == SIZE
        assert float(stream.average_rate or 0) == pytest.approx(fps)
    assert len(frames(content)) == round(duration * fps) + 1 + round(fps)


def test_every_frame_reads_back_as_it_was_drawn_but_for_what_the_eye_does_not_see() -> None:
    film = make_film(PICTURE, *rolling(), size=SIZE, fps=10.0, video=True, title="A coin")
    read = frames(mp4(film, 10.0))
    for drawn, shown in zip(film.frames(), read, strict=False):
        error = np.abs(drawn.astype(int) - shown.astype(int)).max(axis=-1)
        assert np.median(error) < 4
        assert np.quantile(error, 0.98) < 40  # colours are stored at half the resolution


def test_a_long_motion_keeps_its_speed_in_a_film() -> None:
    film = make_film(PICTURE, *rolling(60.0, 0.02), size=SIZE, fps=25.0, video=True)
    assert (film.script.playback.speed, len(film)) == (1.0, 1501)


def test_odd_sides_and_a_missing_library_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    odd, even = (make_film(PICTURE, *rolling(), size=(w, 150), video=True) for w in (201, 200))
    with pytest.raises(InputError, match="201 x 150 has an odd side"):
        mp4(odd, 25.0)
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(InputError, match="pip install 'kinolab"):
        mp4(even, 25.0)


def test_plan_video_films_a_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    problem = kinolab.load("pendulum_swingup")
    plan = problem.solve(planner="rrt_fast", seed=1, max_iterations=5000, optimize=False)
    assert plan.trajectory is not None
    write_run(tmp_path, problem, plan)
    size = ["--size", "160x120", "--fps", "10", "--view", "side", "--speed", "2", "--quiet"]
    assert run(["video", str(tmp_path), *size]) == 0
    assert capsys.readouterr().out.strip() == str(tmp_path / "animation.mp4")
    read = frames((tmp_path / "animation.mp4").read_bytes())
    assert read[0].shape == (120, 160, 3)
    assert len(read) == int(np.ceil(plan.trajectory.duration / 0.2 - 1e-9)) + 1 + 10
    for size in (["--size", "161x120"], ["--size", "big"], ["--fps", "0"]):
        assert run(["video", str(tmp_path), *size]) == 2
    write_run(tmp_path, problem, plan)
    assert not (tmp_path / "animation.mp4").exists()
