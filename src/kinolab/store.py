"""What takes long to make, kept on disk by its kind and by all that determines it.

An entry that does not match its own checksum is made anew; it is never trusted. Where nothing can
be written, everything is made anew.
"""

from __future__ import annotations

import hashlib
import io
import os
import pickle
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
import platformdirs
from numpy.typing import ArrayLike, NDArray

from kinolab.files import discard, keep_last_used, read_sealed, touch, write_sealed

T = TypeVar("T")


def folder() -> Path:
    """Return where entries are kept; the variable KINOLAB_CACHE overrides it."""
    override = os.environ.get("KINOLAB_CACHE")
    return Path(override) if override else platformdirs.user_cache_path("kinolab")


def digest_of(*parts: str | bytes) -> str:
    """Return what stands for contents, in hexadecimal digits."""
    digest = hashlib.sha256()
    for part in parts:
        content = part.encode() if isinstance(part, str) else part
        digest.update(len(content).to_bytes(8, "little"))
        digest.update(content)
    return digest.hexdigest()


@cache
def code_in(*places: Path) -> str:
    """Return a digest of the code in files and below folders: any change makes another thing."""
    found = (sorted(place.rglob("*.py")) if place.is_dir() else [place] for place in places)
    return digest_of(*(path.read_bytes() for paths in found for path in paths))


@dataclass(frozen=True)
class Kind(Generic[T]):
    """Entries of one kind.

    Attributes:
        name: The suffix of their files.
        pack: Returns the bytes of what is kept.
        unpack: Returns what bytes stand for, and may raise anything if they do not.
        made_by: Files and folders of the code that makes them.
        most: Size of all of them in [bytes], above which those unused for longest go.
    """

    name: str
    pack: Callable[[T], bytes]
    unpack: Callable[[memoryview], T]
    made_by: Sequence[Path] = ()
    most: int | None = None

    @cached_property
    def magic(self) -> bytes:
        """Return what their files begin with."""
        return f"kinolab {self.name}\n".encode()

    def get(self, content: Iterable[str | bytes], make: Callable[[], T]) -> T:
        """Return what all of some content determines, made only where it is not on disk."""
        content = tuple(content)
        found = self.find(content)
        if found is None:
            found = make()
            self.keep(content, found)
        return found

    def find(self, content: Iterable[str | bytes]) -> T | None:
        """Return what was kept for some content; None where there is nothing, or it is damaged."""
        path = self.path(content)
        kept = read_sealed(path, self.magic)
        if kept is None:
            return None
        if self.most is not None:
            touch(path)
        try:
            return self.unpack(kept)
        except Exception:
            discard(path, "was damaged")
            return None

    def keep(self, content: Iterable[str | bytes], made: T) -> None:
        """Keep what some content determines."""
        path = self.path(content)
        write_sealed(path, self.magic, self.pack(made))
        if self.most is not None:
            keep_last_used(path, self.most)

    def path(self, content: Iterable[str | bytes]) -> Path:
        """Return where an entry is."""
        return folder() / f"{digest_of(code_in(*self.made_by), *content)}.{self.name}"


def pack_arrays(arrays: Iterable[ArrayLike]) -> bytes:
    """Return arrays of any shape in NumPy's format, one behind the other."""
    file = io.BytesIO()
    for array in arrays:
        np.lib.format.write_array(file, np.asarray(array, order="C"), allow_pickle=False)
    return file.getvalue()


def unpack_arrays(content: memoryview, *dtypes: type[np.generic]) -> list[NDArray[Any]]:
    """Return what ``pack_arrays`` packed: arrays of any shape, of the types given.

    Raises:
        ValueError: If it is something else, or its arrays have other types.
    """
    found, rest = [], content
    for _ in dtypes:
        # 2**12 bytes, of arrays in NumPy's format 1.0: 128 but for long shapes
        header = io.BytesIO(rest[: (2**12)])
        np.lib.format.read_magic(header)
        shape, _, dtype = np.lib.format.read_array_header_1_0(header)
        end = header.tell() + int(np.prod(shape)) * dtype.itemsize
        packed = np.frombuffer(rest[header.tell() : end], dtype).reshape(shape)
        found.append(packed.copy())  # its place in the file need not suit its type
        rest = rest[end:]
    if len(rest) or [array.dtype for array in found] != [*map(np.dtype, dtypes)]:
        raise ValueError("it holds other arrays")
    return found


def pickled(name: str, sort: type[T]) -> Kind[T]:
    """Return a kind of plain data of one class."""

    def unpack(content: memoryview) -> T:
        found = pickle.loads(content)
        if not isinstance(found, sort):
            raise TypeError(f"it is not a {sort.__name__}")
        return found

    return Kind(name, pickle.dumps, unpack)
