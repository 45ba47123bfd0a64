"""A motion as a table with units: CSV, Parquet, HDF5 and NPZ."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from importlib.metadata import version
from typing import Any, NamedTuple

import numpy as np

from kinolab.dynamics.model.units import control_units, state_units
from kinolab.lazy import library_of
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory

TIME_UNIT = "s"


class Block(NamedTuple):
    """Quantities of one kind.

    Attributes:
        name: As ``Trajectory`` calls it: x, u or references.
        kind: What they are, in words.
        values: Shape (N+1, n), or of what is held between knots (N, n).
        names: One per column.
        units: One per column; empty if dimensionless.
    """

    name: str
    kind: str
    values: Array
    names: tuple[str, ...]
    units: tuple[str, ...]


def blocks(problem: PlanningTask, trajectory: Trajectory) -> Iterator[Block]:
    """Yield a motion's states and inputs, and its references if there are any."""
    model = problem.model
    x, u, references = trajectory.x, trajectory.u, trajectory.references
    yield Block("x", "state", x, trajectory.state_names, state_units(model))
    yield Block("u", "input", u, trajectory.control_names, control_units(model.plant))
    if names := trajectory.reference_names:
        yield Block("references", "reference", references, names, control_units(model))


def about(problem: PlanningTask) -> dict[str, str]:
    """Return what a table says of itself."""
    return {
        "machine": problem.machine.name,
        "scenario": problem.scenario.title,
        "inputs": "held from each knot to the next; none at the last one",
        "written_by": f"kinolab {version('kinolab')}",
    }


def with_unit(name: str, unit: str) -> str:
    """Return a column's name with its unit: ``x [m]``."""
    return f"{name} [{unit}]" if unit else name


def csv_table(problem: PlanningTask, trajectory: Trajectory) -> bytes:
    """Return the motion as CSV with units in the header; the last row has no inputs."""
    parts = blocks(problem, trajectory)
    heads = [
        with_unit(*pair) for part in parts for pair in zip(part.names, part.units, strict=True)
    ]
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow([with_unit("t", TIME_UNIT), *heads])
    _, _, rows = trajectory.to_csv().partition("\n")
    return (out.getvalue() + rows).encode()


def npz_table(problem: PlanningTask, trajectory: Trajectory) -> bytes:
    """Return the motion as NPZ: t, x, u, and the names and units of their columns."""
    out = io.BytesIO()
    tables: dict[str, Any] = {"t": trajectory.t}
    for part in blocks(problem, trajectory):
        tables[part.name] = part.values
        tables[f"{part.name}_names"] = np.array(part.names, dtype=str)
        tables[f"{part.name}_units"] = np.array(part.units, dtype=str)
    np.savez(out, **tables)
    return out.getvalue()


def hdf5_table(problem: PlanningTask, trajectory: Trajectory) -> bytes:
    """Return the motion as HDF5: datasets t, x and u with attributes ``names`` and ``units``."""
    h5py = library_of("hdf5", "h5py", "HDF5 files need h5py")
    out = io.BytesIO()
    with h5py.File(out, "w") as file:
        file.attrs.update(about(problem))
        file.create_dataset("t", data=trajectory.t).attrs["units"] = TIME_UNIT
        for part in blocks(problem, trajectory):
            table = file.create_dataset(part.name, data=part.values)
            table.attrs.update({"names": list(part.names), "units": list(part.units)})
    return out.getvalue()


def parquet_table(problem: PlanningTask, trajectory: Trajectory) -> bytes:
    """Return the motion as Parquet: a column each, with ``unit`` and ``kind`` as its metadata.

    What is held from knot to knot is null in the last row.
    """
    arrow = library_of("bench", "pyarrow", "Parquet files need PyArrow")
    parquet = library_of("bench", "pyarrow.parquet", "Parquet files need PyArrow")
    rows = len(trajectory.t)
    fields, columns = [], []

    def add(name: str, values: Array, unit: str, kind: str) -> None:
        told = {"unit": unit, "kind": kind}
        fields.append(arrow.field(name, arrow.float64(), metadata=told))
        held = [*values.tolist(), *[None] * (rows - len(values))]
        columns.append(arrow.array(held, arrow.float64()))

    add("t", trajectory.t, TIME_UNIT, "time")
    for part in blocks(problem, trajectory):
        for name, unit, values in zip(part.names, part.units, part.values.T, strict=True):
            add(name, values, unit, part.kind)
    out = io.BytesIO()
    schema = arrow.schema(fields, metadata=about(problem))
    parquet.write_table(arrow.Table.from_arrays(columns, schema=schema), out)
    return out.getvalue()
