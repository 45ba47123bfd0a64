"""The rows of a study, and its table in Apache Parquet."""

from __future__ import annotations

import io
import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from kinolab.errors import is_broken
from kinolab.files import write_whole
from kinolab.lazy import library_of
from kinolab.untrusted import json_of

PARQUET = "results.parquet"
NEED = "studies are written with pyarrow"
Row = Mapping[str, Any]
OBJECTS = ("settings", "fixed", "statistics", "versions")  # texts that are JSON
KINDS = {  # of columns, as Arrow names them
    "text": "string",
    "whole": "int64",
    "number": "double",
    "truth": "bool",
    "pairs": "list of 2 doubles each",
}
ALWAYS = ("index", "scenario", "planner", "seed", "status", "solved")  # never null


@dataclass(frozen=True)
class Column:
    """A column of the table.

    Attributes:
        name: Its name.
        kind: One of ``KINDS``; ``pairs`` is a list of two numbers each.
        meaning: A phrase; with its unit.
        timed: Whether it may differ when the same run is made again.
    """

    name: str
    kind: str
    meaning: str
    timed: bool = False


CONTENT = tomllib.loads(files(__package__).joinpath("columns.toml").read_text("utf-8"))
COLUMNS = tuple(
    Column(name, kind, meaning, part == "timed")
    for part, own in CONTENT.items()
    for name, (kind, meaning) in own.items()
)


def fits(row: object) -> bool:
    """Whether something is a row: every column, of its kind or null, and what no row is without."""
    return (
        isinstance(row, dict)
        and all(column.name in row and _holds(column, row[column.name]) for column in COLUMNS)
        and all(row[name] is not None for name in ALWAYS)
    )


def _holds(column: Column, value: object) -> bool:
    match column.kind:
        case _ if value is None:
            return True
        case "text":
            if not isinstance(value, str) or (not value.isascii() and is_broken(value)):
                return False
            try:
                return column.name not in OBJECTS or isinstance(json_of(value), dict)
            except (ValueError, RecursionError):
                return False
        case "whole":
            return isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**63
        case "number":
            return _is_number(value)
        case "truth":
            return isinstance(value, bool)
    pairs = value if isinstance(value, list) else [None]
    return all(
        isinstance(pair, list) and len(pair) == 2 and all(map(_is_number, pair)) for pair in pairs
    )


def _is_number(value: object) -> bool:
    """Say whether a column of numbers takes a value exactly."""
    if isinstance(value, int) and not isinstance(value, bool):
        return abs(value) < 2**53
    return isinstance(value, float) and math.isfinite(value)


def table_of(rows: Iterable[Row]) -> Any:
    """Return rows as a table of pyarrow, in the order of the study."""
    pa = library_of("bench", "pyarrow", NEED)
    pairs = pa.list_(pa.list_(pa.float64(), 2))
    types = {k: pairs if k == "pairs" else pa.type_for_alias(name) for k, name in KINDS.items()}
    ordered = sorted(rows, key=lambda row: row["index"])
    fields = [
        pa.field(c.name, types[c.kind], metadata={"meaning": c.meaning.encode()}) for c in COLUMNS
    ]
    arrays = [pa.array([row.get(c.name) for row in ordered], types[c.kind]) for c in COLUMNS]
    return pa.Table.from_arrays(arrays, schema=pa.schema(fields))


def write_parquet(path: Path, rows: Iterable[Row]) -> None:
    """Write rows as a Parquet file, whole or not at all."""
    library_of("bench", "pyarrow", NEED)
    import pyarrow.parquet as pq

    out = io.BytesIO()
    pq.write_table(table_of(rows), out, compression="zstd")
    write_whole(path, out.getvalue())
