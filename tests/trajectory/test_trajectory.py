"""Trajectories: nothing is lost in files, nothing broken is read, and pieces fit together."""

from __future__ import annotations

import io
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Literal

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
        (GOOD.replace("1.5", "1_5e-1"), "line 3 column x: '1_5e-1' is not a number"),
        (GOOD.replace("1.5", "١"), "line 3 column x"),  # a digit, but not of everybody's
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


# --- between the knots, and for other libraries ---


def sampled(h: float) -> Trajectory:
    """Return x = sin(t), whose rate is a state, and y = cos(t), whose rate is none."""
    t = np.arange(0.0, 2.0 + h / 2, h)
    x = np.column_stack([np.sin(t), np.cos(t), np.cos(t)])
    return Trajectory(t, x, t[:-1, None], ("x", "y", "x_dot"), ("u",))


def test_states_between_knots_converge_by_the_order_that_their_rates_allow() -> None:
    errors = []
    for h in (0.1, 0.05):
        times = np.linspace(0, 2, 997)
        found = sampled(h).at(times).x
        true = np.column_stack([np.sin(times), np.cos(times), np.cos(times)])
        errors.append(np.abs(found - true).max(axis=0))
    cubic, chord, rate = errors[0] / errors[1]
    assert 13 < cubic < 19  # 2^4
    assert 3.5 < chord < 4.5  # 2^2
    assert 3.5 < rate < 4.5


def test_at_a_knot_the_motion_is_the_stored_one() -> None:
    motion = sampled(0.1)
    for k in (0, 7, len(motion.t) - 1):
        now = motion.at(motion.t[k])
        assert now.x == pytest.approx(motion.x[k], abs=1e-15)
        assert now.u.tolist() == motion.u[min(k, len(motion.u) - 1)].tolist()
    assert motion.at([0.0, 0.15]).u[:, 0].tolist() == [0.0, 0.1]  # held from 0.1 to 0.2


def test_an_attitude_between_two_is_halfway_on_the_great_circle() -> None:
    names, half = ("R_x", "R_y", "R_z", "R_w"), np.sqrt(0.5)
    q = np.array([[0.0, 0.0, 0.0, 1.0], [half, 0.0, 0.0, half]])  # a quarter turn about x
    turning = Trajectory(np.array([0.0, 1.0]), q, np.zeros((1, 0)), names, ())
    angle = np.pi / 8  # half of half a quarter turn
    assert turning.at(0.5).x == pytest.approx([np.sin(angle), 0, 0, np.cos(angle)], abs=1e-15)


@pytest.mark.parametrize("t", [-0.1, 2.1, np.nan, [0.0, 3.0]])
def test_a_time_outside_the_motion_is_refused(t: float) -> None:
    with pytest.raises(
        InputError, match=r"at t: .* s is outside the motion. Give times from 0 to 2 s\."
    ):
        sampled(0.1).at(t)


def test_a_time_that_is_no_number_is_refused() -> None:
    with pytest.raises(InputError, match=r"^at t: it is 'noon'\."):
        sampled(0.1).at("noon")


def test_a_data_frame_has_the_columns_of_the_file(monkeypatch: pytest.MonkeyPatch) -> None:
    class Frame(dict[str, NDArray[np.float64]]):
        """What both libraries are given: columns by name."""

    monkeypatch.setitem(sys.modules, "pandas", None)
    monkeypatch.setitem(sys.modules, "polars", SimpleNamespace(DataFrame=Frame))
    motion = sampled(0.5)
    frame = motion.to_dataframe()
    assert list(frame) == motion.to_csv().splitlines()[0].split(",")
    assert frame["x_dot"].tolist() == motion.x[:, 2].tolist()
    assert np.isnan(frame["u"][-1])
    with pytest.raises(InputError, match=r"^to_dataframe: pandas is not installed\. pip install"):
        motion.to_dataframe("pandas")
    monkeypatch.setitem(sys.modules, "polars", None)
    with pytest.raises(InputError, match=r"pandas is not installed, and polars is not installed"):
        motion.to_dataframe()
    with pytest.raises(InputError, match=r"^to_dataframe: no library is called 'panda'\."):
        motion.to_dataframe("panda")  # type: ignore[arg-type]


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_a_data_frame_is_one_of_its_library(library: Literal["pandas", "polars"]) -> None:
    frame = pytest.importorskip(library).DataFrame
    made = sampled(0.5).to_dataframe(library)
    assert isinstance(made, frame)
    assert made.shape == (5, 5)


def test_a_motion_is_written_where_it_is_told(tmp_path: Path) -> None:
    motion = sampled(0.5)
    text = motion.to_csv(tmp_path / "motion.csv")
    assert (tmp_path / "motion.csv").read_text(encoding="utf-8") == text == motion.to_csv()


def test_a_motion_is_shown_in_a_line() -> None:
    assert repr(sampled(0.5)) == "<Trajectory of 2.00 s, 5 knots of x, y, x_dot>"


def test_a_table_of_too_many_knots_is_refused(tmp_path: Path) -> None:
    """48 MB of rows would be looked at for many minutes."""
    path = tmp_path / "trajectory.csv"
    rows = "".join(f"{k / 100},0.0,0.0\n" for k in range(100_001))
    path.write_text(f"t,x,u\n{rows}")
    with pytest.raises(InputError, match="more than 100000 knots"):
        read_csv(path, ("x",), ("u",))


def test_a_byte_order_mark_is_no_part_of_a_csv_file(tmp_path: Path) -> None:
    """Spreadsheets on Windows write one before the header."""
    path = tmp_path / "trajectory.csv"
    path.write_bytes(b"\xef\xbb\xbft,a,b\n0.0,1.0,0.5\n1.0,2.0,\n")
    assert read_csv(path, ("a",), ("b",)).x[:, 0].tolist() == [1.0, 2.0]
