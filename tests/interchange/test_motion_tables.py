"""Other libraries read the tables: the csv module, NumPy, h5py and PyArrow."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab import cli
from kinolab.cli.commands.machines.plan_export import OF_RUNS
from kinolab.errors import InputError
from kinolab.interchange import export_motion
from kinolab.interchange.motion_export import EXPORTS
from kinolab.trajectory import Trajectory

UNITS = {"t": "s", "x": "m", "phi": "rad", "x_dot": "m/s", "phi_dot": "rad/s"}


@pytest.fixture(scope="module")
def problem() -> kinolab.Problem:
    return kinolab.load("rolling_disk_maze")


@pytest.fixture(scope="module")
def motion(problem) -> Trajectory:  # type: ignore[no-untyped-def]
    return kinolab.simulate(problem, lambda t, _: [0.2, 0.05 * np.sin(3 * t)], duration=1.0)


def test_the_command_knows_all_formats() -> None:
    assert tuple(EXPORTS) == OF_RUNS


def test_csv_has_names_and_units_and_every_digit(tmp_path: Path, problem, motion) -> None:  # type: ignore[no-untyped-def]
    path = export_motion(tmp_path / "new" / "motion.csv", problem, motion, "csv")
    head, *rows = list(csv.reader(path.read_text().splitlines()))
    assert {f"{name} [{UNITS[name]}]" for name in UNITS if name in ("t", "x", "phi")} <= set(head)
    assert [float(row[0]) for row in rows] == motion.t.tolist()
    found = np.array([[float(value) for value in row[: 1 + motion.x.shape[1]]] for row in rows])
    assert np.array_equal(found[:, 1:], motion.x)
    assert rows[-1][-motion.u.shape[1] :] == [""] * motion.u.shape[1]


def test_npz_has_arrays_names_and_units(tmp_path: Path, problem, motion) -> None:  # type: ignore[no-untyped-def]
    with np.load(export_motion(tmp_path / "m.npz", problem, motion, "npz")) as found:
        assert np.array_equal(found["t"], motion.t)
        assert np.array_equal(found["x"], motion.x)
        assert np.array_equal(found["u"], motion.u)
        units = dict(zip(found["x_names"].tolist(), found["x_units"].tolist(), strict=True))
        assert {name: units[name] for name in UNITS if name in units} == {
            name: unit for name, unit in UNITS.items() if name in units
        }
        assert {"x", "phi"} <= set(units)
        assert found["u_units"].tolist() == ["N m", "N m"]


def test_h5py_reads_hdf5(tmp_path: Path, problem, motion) -> None:  # type: ignore[no-untyped-def]
    h5py = pytest.importorskip("h5py")
    with h5py.File(export_motion(tmp_path / "m.h5", problem, motion, "hdf5")) as found:
        assert found.attrs["machine"] == "rolling_disk"
        assert np.array_equal(found["t"][:], motion.t)
        assert found["t"].attrs["units"] == "s"
        assert np.array_equal(found["x"][:], motion.x)
        assert list(found["x"].attrs["names"]) == list(motion.state_names)
        assert np.array_equal(found["u"][:], motion.u)
        assert list(found["u"].attrs["units"]) == ["N m", "N m"]


def test_arrow_reads_parquet_with_units_and_nulls(tmp_path: Path, problem, motion) -> None:  # type: ignore[no-untyped-def]
    parquet = pytest.importorskip("pyarrow.parquet")
    found = parquet.read_table(export_motion(tmp_path / "m.parquet", problem, motion, "parquet"))
    assert found.column_names == ["t", *motion.state_names, *motion.control_names]
    for name, values in zip(motion.state_names, motion.x.T, strict=True):
        assert np.array_equal(found[name].to_numpy(), values)
    last = [found[name][-1].as_py() for name in motion.control_names]
    assert last == [None, None]
    assert [found[name].null_count for name in motion.control_names] == [1, 1]
    assert found.schema.field("phi").metadata == {b"unit": b"rad", b"kind": b"state"}
    assert found.schema.metadata[b"machine"] == b"rolling_disk"


def test_what_a_table_holds_is_verified_after_it_was_read(tmp_path: Path) -> None:
    """A round trip through Parquet: the certificate of what comes back passes."""
    parquet = pytest.importorskip("pyarrow.parquet")
    problem = kinolab.load("pendulum_swingup")
    plan = problem.solve(seed=1, improve=0)
    path = export_motion(tmp_path / "m.parquet", problem, plan.trajectory, "parquet")
    table = parquet.read_table(path)
    names, inputs = plan.trajectory.state_names, plan.trajectory.control_names
    read = Trajectory(
        table["t"].to_numpy(),
        np.column_stack([table[name].to_numpy() for name in names]),
        np.column_stack([table[name].to_numpy(zero_copy_only=False)[:-1] for name in inputs]),
        names,
        inputs,
    )
    assert kinolab.verify(problem, read).passed


def test_feedback_s_references_are_kept(tmp_path: Path) -> None:
    problem = kinolab.load("unicycle_slalom")
    motion = kinolab.simulate(problem, duration=0.2)
    with np.load(export_motion(tmp_path / "m.npz", problem, motion, "npz")) as found:
        assert found["references_names"].tolist() == list(motion.reference_names)
        assert np.array_equal(found["references"], motion.references)


def test_an_unknown_format_is_named(tmp_path: Path, problem, motion) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=r"no format is called 'excel'.*parquet"):
        export_motion(tmp_path / "m", problem, motion, "excel")


def test_the_command_writes_a_run_s_motion(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    kinolab.load("pendulum_swingup").solve(seed=1, improve=0).save(tmp_path / "run")
    out = str(tmp_path / "out")
    assert cli.run(["export", str(tmp_path / "run"), "--format", "csv", "--out", out]) == 0
    assert (tmp_path / "out" / "motion.csv").read_text().startswith("t [s],")
    assert cli.run(["export", str(tmp_path / "run"), "--out", out]) == 2
    assert "Give --format csv, npz" in capsys.readouterr().err
    assert cli.run(["export", "pendulum", "--format", "csv"]) == 2
    assert (
        "csv is a format of motions, and 'pendulum' is no folder. Give the folder"
        in capsys.readouterr().err
    )
    assert cli.run(["export", str(tmp_path / "run"), "--format", "c", "--out", out]) == 0
    assert "double" in (tmp_path / "out" / "pendulum.c").read_text()  # the machine of the run


def test_motions_of_other_machines_and_damaged_ones_are_refused(
    tmp_path: Path, problem: kinolab.Problem, motion: Trajectory
) -> None:
    swing = kinolab.simulate(kinolab.load("pendulum_swingup"), duration=0.2)
    with pytest.raises(InputError, match="its states are theta, theta_dot; those of rolling_disk"):
        export_motion(tmp_path / "m.csv", problem, swing, "csv")
    x = motion.x.copy()
    x[1, 0] = np.nan
    with pytest.raises(InputError, match=r"(?s)times do not increase.*not finite"):
        export_motion(tmp_path / "m.csv", problem, replace(motion, t=motion.t[::-1], x=x), "csv")
    assert not (tmp_path / "m.csv").exists()


def test_a_place_that_is_no_folder_is_named(
    tmp_path: Path, problem: kinolab.Problem, motion: Trajectory
) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"file/m\.csv: it cannot be written"):
        export_motion(tmp_path / "file" / "m.csv", problem, motion, "csv")
    with pytest.raises(InputError, match="it names no file"):
        export_motion("", problem, motion, "csv")
    assert cli.run(["export", "pendulum", "--out", str(tmp_path / "file")]) == 2
