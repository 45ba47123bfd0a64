"""The file that a motion becomes."""

from __future__ import annotations

from itertools import count
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from kinolab.dynamics.facts.machine_facts import BodyGeometry
from kinolab.dynamics.language.shapes import Disk
from kinolab.files import whole_file
from kinolab.show.film import gif
from kinolab.show.film.crew import Crew, Share
from kinolab.show.film.gif import UNCHANGED, change, gif_parts, indexed, shared_palette
from kinolab.show.film.staging.text import letter, time_stamp
from kinolab.show.scene.picture import Picture
from tests.show.film.films import box_surface, make_film, write_gif

SIZE = (200, 150)
PICTURE = Picture(
    bodies=[BodyGeometry("coin", (Disk(0.25, 0.05, "y"),))],
    obstacles=[box_surface("wall", (0.2, 2.0, 0.5), (1.0, 1.5, 0.25))],
    ground=True,
    bounds={"x": (0.0, 3.0), "y": (0.0, 2.0)},
)


def rolling(duration: float = 1.0, speed: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """A coin that rolls along x."""
    times = np.linspace(0.0, duration, 21)
    poses = np.zeros((21, 1, 3, 4))
    for g, x in zip(poses[:, 0], speed * times, strict=True):
        c, s = np.cos(x / 0.25), np.sin(x / 0.25)
        g[:] = [[c, 0, s, 0.5 + x], [0, 1, 0, 0.4], [-s, 0, c, 0.25]]
    return times, poses.reshape(21, 1, 12)


def durations(path: Path) -> list[int]:
    """How long each frame stays, in [ms]."""
    with Image.open(path) as film:
        found = []
        for i in range(film.n_frames):
            film.seek(i)
            found.append(int(film.info["duration"]))
        return found


@pytest.mark.parametrize("speed", [0.0, 1.0])
def test_one_second_at_25_fps_is_25_steps_of_40_ms_and_a_second_at_the_end(
    tmp_path: Path, speed: float
) -> None:
    """Also while nothing moves: no frame is merged with its neighbour."""
    write_gif(tmp_path / "a.gif", PICTURE, *rolling(speed=speed), size=SIZE)
    assert durations(tmp_path / "a.gif") == [40] * 25 + [1000]


def test_the_film_loops_and_has_the_size_that_was_asked_for(tmp_path: Path) -> None:
    write_gif(tmp_path / "a.gif", PICTURE, *rolling(), size=(203, 151))
    with Image.open(tmp_path / "a.gif") as film:
        assert film.size == (203, 151)
        assert film.info["loop"] == 0


def test_every_frame_reads_back_as_it_was_drawn(tmp_path: Path) -> None:
    """255 colours for a few flat ones and their mixtures: a few levels of 255 are lost."""
    write_gif(tmp_path / "a.gif", PICTURE, *rolling(), size=SIZE, title="A coin")
    film = make_film(PICTURE, *rolling(), size=SIZE, title="A coin")
    with Image.open(tmp_path / "a.gif") as file:
        for i, image in enumerate(film.frames()):
            file.seek(i)
            shown = np.asarray(file.convert("RGB")).astype(int)
            error = abs(shown - image.astype(int)).max(axis=-1)
            assert np.quantile(error, 0.99) < 10
            assert error.max() < 80


def test_what_stands_still_does_not_flicker(tmp_path: Path) -> None:
    write_gif(tmp_path / "a.gif", PICTURE, *rolling(), size=SIZE)
    with Image.open(tmp_path / "a.gif") as film:
        corners = []
        for i in range(film.n_frames):
            film.seek(i)
            corners.append(np.asarray(film.convert("RGB"))[-40:, -60:])
    assert all((corner == corners[0]).all() for corner in corners)


def test_a_long_motion_says_how_fast_it_is_shown() -> None:
    film = make_film(PICTURE, *rolling(30.0, 0.05), size=SIZE)
    assert len(film) <= 400
    assert film.script.playback.speed == 2.0
    assert time_stamp(1.25, film.script.playback.speed).endswith("2x")
    assert "x" not in time_stamp(1.25, 1.0)
    assert time_stamp(1.25, 1000.0).endswith(" 1000x")


def test_a_failed_write_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []

    def failing(*_: object, **__: object) -> list[bytes]:
        calls.append(1)
        if len(calls) > 3:
            raise OSError("disk full")
        return [b""]

    monkeypatch.setattr(gif, "getdata", failing)
    with pytest.raises(OSError, match="disk full"):
        write_gif(tmp_path / "a.gif", PICTURE, *rolling(), size=SIZE)
    assert list(tmp_path.iterdir()) == []


def test_a_failed_write_keeps_what_was_there(tmp_path: Path) -> None:
    path = tmp_path / "a.gif"
    path.write_bytes(b"before")

    def write_half() -> None:
        with whole_file(path) as file:
            file.write(b"half")
            raise RuntimeError("stopped")

    with pytest.raises(RuntimeError, match="stopped"):
        write_half()
    assert path.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [path]


def test_same_motion_same_bytes(tmp_path: Path) -> None:
    for name in ("a.gif", "b.gif"):
        write_gif(tmp_path / name, PICTURE, *rolling(), size=SIZE)
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.gif").read_bytes()


def test_poses_may_be_matrices(tmp_path: Path) -> None:
    times, poses = rolling()
    write_gif(tmp_path / "a.gif", PICTURE, times, poses.reshape(21, 1, 3, 4), size=SIZE)
    assert len(durations(tmp_path / "a.gif")) == 26


def test_a_single_row_is_a_film_of_one_frame(tmp_path: Path) -> None:
    times, poses = rolling()
    write_gif(tmp_path / "a.gif", PICTURE, times[:1], poses[:1], size=SIZE)
    with Image.open(tmp_path / "a.gif") as film:
        assert getattr(film, "n_frames", 1) == 1


@pytest.mark.parametrize(
    ("times", "poses", "words"),
    [
        ([0.0, 1.0], np.zeros((3, 1, 12)), "need poses of shape"),
        ([], np.zeros((0, 1, 12)), "at least one row"),
        ([0.0, np.nan], np.zeros((2, 1, 12)), "finite"),
        ([1.0, 0.0], np.zeros((2, 1, 12)), "decrease"),
    ],
)
def test_a_motion_that_makes_no_sense_is_refused_and_nothing_is_written(
    tmp_path: Path, times: list[float], poses: np.ndarray, words: str
) -> None:
    with pytest.raises(ValueError, match=words):
        write_gif(tmp_path / "a.gif", PICTURE, times, poses, size=SIZE)
    assert list(tmp_path.iterdir()) == []


def test_a_small_bright_thing_keeps_its_colour_in_the_palette() -> None:
    """Ten green pixels among 120 000 of a grey ramp."""
    ramp = np.arange(400) // 2 + 20
    image = np.broadcast_to(ramp[:, None], (300, 400, 3)).astype(np.uint8)
    image[5, :10] = (0, 200, 90)
    shown = np.asarray(indexed(image, shared_palette([image])).convert("RGB"))[5, 4].astype(int)
    assert abs(shown - [0, 200, 90]).max() <= 8  # of 255; what six bits per channel resolve twice


def test_no_colour_is_the_index_that_shows_the_frame_before() -> None:
    """Also where more colours are wanted than there are, and where there are a few only."""
    rng = np.random.default_rng(1)
    for many in (rng.integers(0, 256, (200, 300, 3)), rng.integers(0, 2, (20, 30, 3)) * 255):
        image = many.astype(np.uint8)
        assert np.asarray(indexed(image, shared_palette([image]))).max() < UNCHANGED


def test_text_changes_the_head_of_the_picture_and_nothing_else() -> None:
    image = np.full((300, 400, 3), 250, dtype=np.uint8)
    letter(image, "A title that is far too long for a picture of this width, you see", "t")
    assert (image[40:] == 250).all()
    assert (image[:40] < 150).any()


@pytest.mark.parametrize("threads", [2, 3])
def test_one_thread_draws_the_same_bytes_as_several(threads: int) -> None:
    film = make_film(PICTURE, *rolling(2.0), size=SIZE, magnify=True)
    alone, together = (b"".join(gif_parts(film, lambda n=n: Share(n))) for n in (1, threads))
    assert alone == together


def test_the_number_of_threads_may_change_while_a_film_is_drawn() -> None:
    film, asked = make_film(PICTURE, *rolling(2.0), size=SIZE), count()
    turns = b"".join(gif_parts(film, lambda: Share(1 + next(asked) // 5 % 3, next(asked) % 7 < 3)))
    assert turns == b"".join(gif_parts(film))


def test_a_frame_is_the_one_before_and_what_changes() -> None:
    rng = np.random.default_rng(1)
    before = rng.integers(0, 4, (20, 30), dtype=np.uint8)
    after = before.copy()
    after[2:9, 3:11], after[5:18, 9:25] = rng.integers(0, 4, (7, 8)), rng.integers(0, 4, (13, 16))
    image, (left, top) = change(Image.fromarray(after), Image.fromarray(before))
    part, shown = np.asarray(image), before.copy()
    window = shown[top : top + part.shape[0], left : left + part.shape[1]]
    window[part != UNCHANGED] = part[part != UNCHANGED]
    assert (shown == after).all()
    assert (part[:, [0, -1]] != UNCHANGED).any(axis=0).all()  # no smaller rectangle would do
    assert (part[[0, -1]] != UNCHANGED).any(axis=1).all()


def test_machines_are_drawn_alike_one_at_a_time_and_many() -> None:
    film = make_film(PICTURE, *rolling(), size=SIZE)
    for i, image in enumerate(film.frames()):
        assert (image == film.frame(i)).all()


def test_results_are_taken_in_order_and_little_is_done_ahead() -> None:
    begun: list[int] = []
    with Crew(lambda: Share(2)) as crew:
        results = crew.in_order(lambda i: begun.append(i) or i, range(100))
        assert [next(results) for _ in range(5)] == [0, 1, 2, 3, 4]
        assert len(begun) <= 5 + 2
        assert list(results) == list(range(5, 100))
