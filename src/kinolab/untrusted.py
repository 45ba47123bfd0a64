"""Files that somebody else wrote: three laws, and what is too large is refused before it is parsed.

A file of a kind has at most so many bytes (``BYTES``), what is parsed of it at most so many
elements (``ELEMENTS``), and parsing it takes at most so much memory (``MEMORY``). The first is
looked at before anything is parsed and the second before anything is built; both are chosen so that
the worst file takes less than the third: a list of empty lists takes 25 bytes of memory for each of
its own in JSON and TOML, a word 75 in an ASCII PLY and 90 in a DAE, as trimesh reads them.
"""

from __future__ import annotations

import errno
import io
import json
import math
import re
import sys
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kinolab.errors import InputError, Mistake
from kinolab.files import read_ordinary

if TYPE_CHECKING:
    from numpy.typing import NDArray

MEMORY = 4 * 2**30  # [bytes] that reading any one file takes
BYTES = {
    "arrays": 400_000_000,  # in NPZ, unpacked as well
    "cloud": 400_000_000,
    "json": 20_000_000,
    "machine": 2_000_000,
    "map": 100_000_000,  # or a picture
    "materials": 10_000_000,
    "mesh": 200_000_000,
    "mesh in dae": 40_000_000,
    "mesh in obj": 100_000_000,
    "mesh in off": 50_000_000,
    "mesh in ply": 50_000_000,  # as text
    "scenario": 30_000_000,  # 100 000 boxes with every digit take 25 million
    "scene in glb": 20_000_000,  # its JSON
    "table": 50_000_000,  # in CSV
    "xml": 20_000_000,
    "yaml": 20_000,  # whose parser takes 1 ms for each 100 of them
    "zeros in glb": 100_000_000,  # that are not in the file, of which a kilobyte may ask for any
}
ELEMENTS = {
    "bodies": 1000,
    "cells": 36_000_000,  # of a picture: a file of some kilobytes may stand for a terabyte
    "columns": 100,  # of a cloud, of which three are read
    "levels of lists and tables": 200,
    "levels of nodes": 100,  # poses are multiplied from each one up to the root
    "lines": 10_000,
    "links": 1000,
    "materials": 2000,  # each takes half a millisecond
    "nodes": 20_000,  # those that are used several times counted each time
    "obstacles": 100_000,  # each takes 0.1 ms and 5 kB to be made; more belong into a mesh
    "parts of a key": 32,
    "points": 2_000_000,
    "solids": 1000,  # of an STL of text; each takes a millisecond
    "terms": 5_000,  # of an expression: names, numbers and operations
    "terms written out": 2_000_000,  # of a law whose parts are shared
    "triangles": 2_000_000,
    "triangles that are drawn": 50_000,
    "triangles that are simplified": 10_000_000,
    "values": 2_000_000,  # tables and lists included; a box has up to twenty
    "values in yaml": 150_000,
}

_TEXT = re.compile(rb'"(?>[^"\\]|\\.)*+"', re.DOTALL)
_END = b"PK\x05\x06"  # of an archive; 22 bytes where it has no comment
_END_BYTES = 22


def read(path: Path, kind: str, where: str = "", remedy: str = "") -> bytes:
    """Read a file of a kind.

    Args:
        kind: One of ``BYTES``.
        where: What the file is called in messages; its path if left out.
        remedy: What helps where it is too large.

    Raises:
        InputError: If it is too large, no ordinary file, or cannot be read.
    """
    try:
        return bytes(read_ordinary(path, BYTES[kind]))
    except OSError as error:
        remedy = remedy if error.errno == errno.EFBIG else ""
        what = f"it cannot be read: {error.strerror or error}."
        raise InputError([Mistake(where or str(path), what, remedy)]) from error


def refuse_large(size: int, kind: str, where: str, remedy: str = "") -> None:
    """Refuse so many bytes of a kind.

    Raises:
        InputError: If they are more than ``BYTES`` says.
    """
    if size > BYTES[kind]:
        what = f"it is larger than {BYTES[kind] // 10**6} MB."
        raise InputError([Mistake(where, what, remedy)])


def refuse_many(count: int, things: str, where: str, remedy: str = "") -> None:
    """Refuse so many things of a kind.

    Raises:
        InputError: If they are more than ``ELEMENTS`` says.
    """
    if count > ELEMENTS[things]:
        what = f"it has more than {ELEMENTS[things]} {things}."
        raise InputError([Mistake(where, what, remedy)])


def why(error: Exception) -> str:
    """Return what an error of these functions says, without the system's numbers and names."""
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


def json_of(text: str | bytes) -> Any:
    """Parse JSON.

    Raises:
        ValueError: If it is none, or nested too deep.
    """
    content = text.encode(errors="replace") if isinstance(text, str) else text
    most = ELEMENTS["levels of lists and tables"]
    if nesting(content) > most:
        raise ValueError(f"it is nested too deeply, more than {most} lists and tables")
    return json.loads(text, object_pairs_hook=_once)


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return an object whose keys stand once each: which of two counts, readers do not agree on."""
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"{twice!r} stands twice in one object")
    return found


def nesting(content: bytes) -> int:
    """Return how deep lists and tables of JSON are nested; of anything else, any number."""
    import numpy as np  # late: scenarios need none

    signs = np.frombuffer(_TEXT.sub(b"", content), np.uint8)
    opened = np.isin(signs, np.frombuffer(b"[{", np.uint8)).astype(np.int32)
    opened -= np.isin(signs, np.frombuffer(b"]}", np.uint8))
    return int(np.cumsum(opened, dtype=np.int32).max(initial=0))


def json_file(path: Path) -> Any:
    """Read a file of JSON.

    Raises:
        OSError: If it cannot be read, or is too large.
        ValueError: If it is no JSON, or nested too deep.
    """
    return json_of(bytes(read_ordinary(path, BYTES["json"])))


def text_file(path: Path) -> str:
    """Read a file of text in UTF-8, with or without the byte order mark that Windows adds.

    Raises:
        OSError: If it cannot be read, or is larger than a table in CSV may be.
        UnicodeDecodeError: If it is none.
    """
    return read_ordinary(path, BYTES["table"]).decode("utf-8-sig")


def array_file(path: Path) -> dict[str, NDArray[Any]]:
    """Read the arrays of an NPZ file as NumPy writes them, by name; any shape will do.

    What its entries unpack to, and what their headers say of them, is compared before anything is
    unpacked: a file of a kilobyte may stand for a terabyte.

    Raises:
        OSError: If it cannot be read, or is too large.
        ValueError: If it is no such file, or unpacks to too much.
    """
    content = bytes(read_ordinary(path, most := BYTES["arrays"]))
    end = content[-_END_BYTES:]
    if not end.startswith(_END) or end[-2:] != b"\0\0":
        raise ValueError("it does not end as an archive does")
    if int.from_bytes(end[12:16], "little") > 100_000:  # bytes that say what some 1000 entries are
        raise ValueError("it has too many entries")
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            entries = archive.infolist()
            if sum(entry.file_size for entry in entries) > most:
                raise ValueError(f"its arrays take more than {most // 10**6} MB")
            return {
                entry.filename.removesuffix(".npy"): _array(archive, entry) for entry in entries
            }
    except ValueError:
        raise
    except Exception as error:  # zipfile, zlib and NumPy raise whatever the bytes provoke
        raise ValueError(f"{type(error).__name__}: {error}") from error


def _array(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> NDArray[Any]:
    import numpy as np  # late, as above
    from numpy.lib import format as npy

    if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) or entry.flag_bits & 1:
        raise ValueError(f"{entry.filename} is packed as NumPy packs nothing")
    with archive.open(entry) as file:
        version = npy.read_magic(file)
        headers = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
        if version not in headers:
            raise ValueError(f"{entry.filename} is an array of version {version}")
        shape, by_columns, dtype = headers[version](file)
        size = math.prod(shape) * dtype.itemsize
        if dtype.hasobject or min(shape, default=0) < 0 or size != entry.file_size - file.tell():
            raise ValueError(f"{entry.filename} is not as large as it says")
        content = bytearray(file.read(size))
    if not size:
        return np.zeros(shape, dtype)
    if dtype.kind == "U":  # NumPy writes four bytes a character, and believes them
        codes = np.frombuffer(content, np.dtype(np.uint32).newbyteorder(dtype.byteorder))
        if codes.max() > sys.maxunicode:
            raise ValueError(f"{entry.filename} is no text")
    return np.frombuffer(content, dtype).reshape(shape, order="F" if by_columns else "C")
