"""Points that somebody else measured: PLY, PCD and lines of numbers.

Source: Turk, The PLY polygon file format, 1994; the PCD file format, version 0.7,
https://pointclouds.org/documentation/tutorials/pcd_file_format.html.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from kinolab.errors import InputError
from kinolab.numerics.arrays import Array
from kinolab.untrusted import ELEMENTS, read
from kinolab.world.meshes.mesh import locate
from kinolab.world.meshes.mesh_reading import refusal

FORMATS = ("ply", "pcd", "xyz")
HEAD_BYTES = 10_000  # in which a header ends
AXES = ("x", "y", "z")
PLY_TYPES = {
    **{"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1"},
    **{"short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2"},
    **{"int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4"},
    **{"float": "f4", "float32": "f4", "double": "f8", "float64": "f8"},
}
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


def read_cloud(path: str | Path, *, root: Path) -> Array:
    """Read the points (n, 3) of a cloud in the file's units, those that are no numbers included.

    Args:
        path: The file; a relative path is taken from ``root``.
        root: The folder of the scenario, which the file may not leave.

    Raises:
        InputError: If it is missing, too large, or none of these.
    """
    where = str(path)
    file = locate(where, root, FORMATS, "cloud")
    content = read(file, "cloud", where, "Thin it out.")
    parse = {"ply": _ply, "pcd": _pcd, "xyz": _xyz}[Path(where).suffix.lower().removeprefix(".")]
    try:
        with np.errstate(all="ignore"):
            return parse(where, content)
    except InputError:
        raise
    except (ValueError, KeyError, IndexError, OverflowError, StopIteration) as error:
        what = f"is not a readable cloud in {Path(where).suffix[1:].upper()}."
        raise refusal(where, what, "It may be cut short; export it again.") from error


def _ply(where: str, content: bytes) -> Array:
    """Read the first element of a PLY file, which must be its vertices."""
    end = re.search(rb"end_header\r?\n", content[:HEAD_BYTES])
    if end is None or not content.startswith(b"ply"):
        raise ValueError("it has no header")
    lines = [line.split() for line in content[: end.start()].decode("latin-1").splitlines()]
    order = ORDERS[next(line[1] for line in lines if line[:1] == ["format"])]
    at = next(k for k, line in enumerate(lines) if line[:1] == ["element"])
    if lines[at][1] != "vertex":
        raise refusal(where, "does not begin with its vertices.", "Export the points alone.")
    fields: list[tuple[str, str, int]] = []
    for line in lines[at + 1 :]:
        if line[:1] == ["element"]:
            break
        if line[:1] == ["property"]:
            fields.append((line[2], PLY_TYPES[line[1]], 1))
    return _table(content[end.end() :], int(lines[at][2]), fields, order)


def _pcd(where: str, content: bytes) -> Array:
    """Read a PCD file; what is compressed is refused."""
    start = re.search(rb"^DATA (\w+)\r?\n", content[:HEAD_BYTES], re.MULTILINE)
    if start is None:
        raise ValueError("it has no header")
    head = content[: start.start()].decode("latin-1").splitlines()
    said = {line.split()[0]: line.split()[1:] for line in head if line.split()}
    if start[1] == b"binary_compressed":
        remedy = "Convert it by pcl_convert_pcd_ascii_binary CLOUD.pcd NEW.pcd 1."
        raise refusal(where, "is compressed, which kinolab does not read.", remedy)
    if start[1] not in (b"ascii", b"binary"):
        raise ValueError("it is of another kind")
    names, sizes, kinds = said["FIELDS"], said["SIZE"], said["TYPE"]
    counts = said.get("COUNT", ["1"] * len(names))
    kinds = [kind.lower() + size for kind, size in zip(kinds, sizes, strict=True)]
    fields = [*zip(names, kinds, map(int, counts), strict=True)]
    return _table(
        content[start.end() :], int(said["POINTS"][0]), fields, "<" if start[1] == b"binary" else ""
    )


def _xyz(where: str, content: bytes) -> Array:
    """Read lines of three numbers or more, between spaces or commas; # begins a comment."""
    text = re.sub(rb"#[^\n]*+", b"", content).replace(b",", b" ").replace(b";", b" ").strip()
    columns = len(text.partition(b"\n")[0].split())
    if columns < len(AXES):
        what = f"has {columns} numbers in its first line, and a point has three."
        raise refusal(where, what, "Write x, y and z of a point in each line.")
    return _numbers(text, columns)[:, :3]


def _table(body: bytes, count: int, fields: Sequence[tuple[str, str, int]], order: str) -> Array:
    """Return x, y and z (n, 3) of a table with named columns.

    Args:
        body: Numbers as text, or rows one after the other.
        count: Rows, at least 0.
        fields: Name, NumPy's word for the type, and how many there are in a row.
        order: Of bytes, empty for text.

    Raises:
        ValueError: If it has fewer rows, or a column is missing or no number.
    """
    names = [name for name, _, _ in fields]
    if count < 0 or not {*AXES} <= {*names} or any(names.count(axis) > 1 for axis in AXES):
        raise ValueError("it has no points")
    if not order:
        first = np.cumsum([0, *(each for _, _, each in fields)])
        rows = _numbers(body, int(first[-1]), count)
        return rows[:, [int(first[names.index(axis)]) for axis in AXES]]
    if not all(re.fullmatch("[iu][1248]|f[248]", kind) for _, kind, _ in fields):
        raise ValueError("a column is no number")
    if sum(each for _, _, each in fields) > ELEMENTS["columns"] or min(e for *_, e in fields) < 1:
        raise ValueError("it has too many columns")
    columns = [(f"{k}", order + kind, (each,)) for k, (_, kind, each) in enumerate(fields)]
    table = np.frombuffer(body, np.dtype(columns), count)
    found = [table[f"{names.index(axis)}"][:, 0].astype(np.float64) for axis in AXES]
    return np.column_stack(found)


def _numbers(text: bytes, columns: int, count: int = -1) -> Array:
    """Return the numbers of a text in rows, so many of them or all; words are a ``ValueError``."""
    if not 0 < columns <= ELEMENTS["columns"] or not text.isascii():
        raise ValueError("it is no table")
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # NumPy warns of what it cannot read, and returns the rest
        try:
            found = np.fromstring(
                text.decode(), sep=" ", count=count * columns if count >= 0 else -1
            )
        except DeprecationWarning as error:
            raise ValueError("it has a word that is no number") from error
    return found.reshape(-1, columns)
