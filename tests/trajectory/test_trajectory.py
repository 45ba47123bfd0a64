"""Trajectories: nothing is lost in files, nothing broken is read, and pieces fit together."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from kinolab import systems
from kinolab.errors import InputError
from kinolab.trajectory import Trajectory, read_csv

STATES, CONTROLS = ("x", "x_dot"), ("push",)
GOOD = "t,x,x_dot,push\n0.0,1.0,2.0,3.0\n0.5,1.5,2.5,\n"


def awkward(seed: int, rows: int) -> Trajectory:
    """Return doubles of every size, the smallest and the largest among them."""
    bits = np.random.default_rng(seed).integers(0, 2**64, (rows, 4), dtype=np.uint64)
    values: NDArray[np.float64] = bits.view(np.float64)
    values[~np.isfinite(values)] = -0.0
    values[0, :3] = 5e-324, np.finfo(float).max, 0.1 + 0.2
    t = np.sort(values[:, 0])
    return Trajectory(t, values[:, 1:3].copy(), values[:-1, 3:].copy(), STATES, CONTROLS)


def bits(array: NDArray[np.float64]) -> bytes:
    return np.ascontiguousarray(array).tobytes()


@pytest.mark.parametrize("seed", range(5))
def test_a_csv_file_gives_back_every_bit(seed: int, tmp_path: Path) -> None:
    written = awkward(seed, 200)
    (tmp_path / "a.csv").write_text(written.to_csv())
    read = read_csv(tmp_path / "a.csv", STATES, CONTROLS)
    assert bits(read.t) == bits(written.t)
    assert bits(read.x) == bits(written.x)
    assert bits(read.u) == bits(written.u)


def test_an_npz_file_gives_back_every_bit_and_the_names() -> None:
    written = awkward(0, 50)
    read = np.load(io.BytesIO(written.to_npz()), allow_pickle=False)
    for key in ("t", "x", "u"):
        assert bits(read[key]) == bits(getattr(written, key))
    assert tuple(read["state_names"]) == STATES
    assert tuple(read["control_names"]) == CONTROLS


def test_the_last_row_of_a_csv_file_has_no_inputs() -> None:
    rows = awkward(0, 3).to_csv().splitlines()
    assert rows[0] == "t,x,x_dot,push"
    assert [row.endswith(",") for row in rows[1:]] == [False, False, True]


def test_a_motion_of_one_knot_is_written_and_read(tmp_path: Path) -> None:
    one = Trajectory(np.zeros(1), np.ones((1, 2)), np.zeros((0, 1)), STATES, CONTROLS)
    (tmp_path / "a.csv").write_text(one.to_csv())
    read = read_csv(tmp_path / "a.csv", STATES, CONTROLS)
    assert (read.t.shape, read.x.shape, read.u.shape) == ((1,), (1, 2), (0, 1))
    assert read.duration == 0.0


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("", "line 1"),
        ("t,x,x_dot\n0,1,2\n", "line 1"),
        ("t,x_dot,x,push\n0,1,2,\n", "line 1"),
        ("t,x,x_dot,push\n", "no knots"),
        (GOOD.replace("1.5", "nan"), "line 3 column x: nan is not finite"),
        (GOOD.replace("3.0", "nan"), "line 2 column push: nan is not finite"),
        (GOOD.replace("2.5,", "2.5,1.0"), "line 3 column push: '1.0' is an input in the last row"),
        (GOOD.replace("1.5", "inf"), "line 3"),
        (GOOD.replace("3.0", "-inf"), "line 2"),
        (GOOD.replace("1.5", ""), "line 3"),
        (GOOD.replace("1.5", "one"), "line 3"),
        (GOOD.replace("2.5,", "2.5,1.0"), "line 3"),  # inputs in the last row
        (GOOD.replace(",3.0", ","), "line 2"),  # none before it
        (GOOD.replace("2.5,", "2.5"), "line 3"),
        (GOOD + "\n", "line 4"),
        (GOOD.replace("1.5", "1" * 200_000), ""),
    ],
)
def test_a_broken_csv_file_is_refused_by_its_line(text: str, place: str, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(InputError) as caught:
        read_csv(tmp_path / "a.csv", STATES, CONTROLS)
    assert "a.csv" in str(caught.value)
    assert place in str(caught.value)


@pytest.mark.parametrize(
    ("t", "x", "u"),
    [
        (np.zeros(2), np.zeros((3, 2)), np.zeros((1, 1))),
        (np.zeros(2), np.zeros((2, 3)), np.zeros((1, 1))),
        (np.zeros(2), np.zeros((2, 2)), np.zeros((2, 1))),
        (np.zeros(2), np.zeros((2, 2)), np.zeros((1, 2))),
        (np.zeros((2, 1)), np.zeros((2, 2)), np.zeros((1, 1))),
        (np.zeros(0), np.zeros((0, 2)), np.zeros((0, 1))),
    ],
)
def test_arrays_that_do_not_fit_together_are_refused(
    t: NDArray[np.float64], x: NDArray[np.float64], u: NDArray[np.float64]
) -> None:
    with pytest.raises(InputError, match="trajectory"):
        Trajectory(t, x, u, STATES, CONTROLS)


# --- pieces ---


def rolled(steps: NDArray[np.float64], seed: int) -> Trajectory:
    """Return any states and inputs of a coin at uneven times."""
    model, random = systems.get("rolling_disk").model(), np.random.default_rng(seed)
    t = np.concatenate([[0.0], np.cumsum(steps)])
    x = random.normal(size=(len(t), model.nx))
    u = random.normal(size=(len(steps), model.nu))
    return Trajectory(t, x, u, model.state_names, model.control_names)


@pytest.mark.parametrize(("begin", "end"), [(0, 12), (0, 5), (4, 9), (9, 12)])
def test_a_piece_put_back_in_its_place_changes_nothing(begin: int, end: int) -> None:
    whole = rolled(np.random.default_rng(1).uniform(0.01, 0.2, 12), 2)
    piece = whole.piece(begin, end)
    assert piece.t[0] == 0.0
    assert piece.duration == pytest.approx(whole.t[end] - whole.t[begin], abs=1e-15)
    again = whole.with_piece(begin, end, piece, systems.get("rolling_disk").model().space)
    assert np.array_equal(again.x, whole.x)
    assert np.array_equal(again.u, whole.u)
    assert np.abs(again.t - whole.t).max() < 1e-15  # [s]; sums of a second, rounded


def test_what_follows_a_quicker_piece_comes_as_much_earlier_and_begins_where_it_ends() -> None:
    whole, space = rolled(np.full(10, 0.1), 3), systems.get("rolling_disk").model().space
    quick = rolled(np.full(2, 0.05), 4)
    joined = whole.with_piece(3, 7, quick, space)
    assert joined.duration == pytest.approx(whole.duration - 4 * 0.1 + 2 * 0.05)
    assert np.array_equal(joined.x[:3], whole.x[:3])
    assert np.array_equal(joined.x[3:6], quick.x)
    moved = joined.x[5:] - whole.x[7:]  # a coin's states have no quaternion: all of them shift
    assert moved == pytest.approx(np.tile(quick.x[-1] - whole.x[7], (len(moved), 1)))
    assert np.array_equal(joined.u, np.vstack([whole.u[:3], quick.u, whole.u[7:]]))
