"""Three laws for files that somebody else wrote, each with its numbers in one table.

A file of a kind has at most so many bytes (``BYTES``), what is parsed of it at most so many
elements (``ELEMENTS``), and parsing it takes at most so much memory (``MEMORY``). The first is
looked at before anything is parsed and the second before anything is built; both are chosen so that
the worst file takes less than the third: a list of empty lists takes 25 bytes of memory for each of
its own in JSON and TOML, a word 75 in an ASCII PLY and 90 in a DAE, as trimesh reads them.
"""

from __future__ import annotations

import errno
from pathlib import Path

from kinolab.errors import InputError, Mistake
from kinolab.files import read_ordinary

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
