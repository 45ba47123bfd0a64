"""Files that somebody else wrote: what is too large or too deep is refused before it is parsed.

How much that is, ``file_laws`` says.
"""

from __future__ import annotations

import io
import json
import math
import re
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinolab.file_laws import BYTES, ELEMENTS
from kinolab.files import read_ordinary

_TEXT = re.compile(rb'"(?>[^"\\]|\\.)*+"', re.DOTALL)
_END = b"PK\x05\x06"  # of an archive; 22 bytes where it has no comment
_END_BYTES = 22
_HEADERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}


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
    if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) or entry.flag_bits & 1:
        raise ValueError(f"{entry.filename} is packed as NumPy packs nothing")
    with archive.open(entry) as file:
        version = np.lib.format.read_magic(file)
        if version not in _HEADERS:
            raise ValueError(f"{entry.filename} is an array of version {version}")
        shape, by_columns, dtype = _HEADERS[version](file)
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
