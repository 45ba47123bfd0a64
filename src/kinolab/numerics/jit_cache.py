"""numba's disk cache with checksums, so that corrupted machine code is never run.

numba unpickles and executes its cache entries unchecked. Here an entry whose checksum does not
match is removed and its function recompiled.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from numba.core.caching import FunctionCache, IndexDataCacheFile, NullCache
from numba.core.event import trigger_event
from numba.core.runtime.nrt import rtsys

from kinolab.files import FileLock, discard, read_sealed, write_sealed
from kinolab.numerics.compiling import WAIT

MAGIC = b"kinolab compiled loop 1\n"
MARK = ".sealed"  # in file names: numba's own files have no checksum


def cache_of(function: Callable[..., Any], kind: type | None = None) -> Any:
    """Return the cache of a function; a null cache if no folder can be written.

    Args:
        function: In Python.
        kind: ``SealedCache`` or one derived from it, which is for other results of compilation.
    """
    try:
        return (kind or SealedCache)(function)
    except (OSError, RuntimeError):
        return NullCache()


class SealedCache(FunctionCache):  # type: ignore[misc]
    """The cache of one function, for all its signatures."""

    _mark = MARK  # in file names, which differ between kinds

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        stamp = self._impl.locator.get_source_stamp()
        name = f"{self._impl.filename_base}{self._mark}"
        self._cache_file = _SealedFiles(self._cache_path, name, stamp)
        self._lock = FileLock(Path(self._cache_path, f"{name}.lock"))

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Return what was compiled for a signature; None if this process has to compile it.

        If another process is compiling the function, this one waits for it.
        """
        found = self._load(signature, context)
        if found is None:
            with trigger_event(WAIT):
                taken = self._lock.acquire()
            found = self._load(signature, context) if taken else None
        if found is not None:
            self.release()
        return found

    def _load(self, signature: Any, context: Any) -> Any:
        """Return what is kept for a signature.

        numba's own method first imports all that compiling may need, SciPy's linear algebra
        included. What is compiled needs numba's runtime alone; its compiler asks for the rest.
        """
        rtsys.initialize(context)
        with self._guard_against_spurious_io_errors():
            return self._load_overload(signature, context)

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Save the machine code of a signature; an unwritable folder only costs time."""
        with suppress(OSError):
            super().save_overload(signature, compiled)
        self.release()

    def release(self) -> None:
        """Let other processes compile the function."""
        self._lock.release()


class _SealedFiles(IndexDataCacheFile):  # type: ignore[misc]
    """An index of signatures, and a file of machine code for each of them."""

    def save(self, key: Any, data: Any) -> None:
        """Save an entry, with its key."""
        super().save(key, (key, data))

    def load(self, key: Any) -> Any:
        """Return an entry; None if it is damaged or missing.

        Two processes that save at once may use one file name for two signatures, so an entry is
        only accepted under the key it was saved with.
        """
        saved = super().load(key)
        fits = isinstance(saved, tuple) and len(saved) == 2 and saved[0] == key
        return saved[1] if fits else None

    def _save_index(self, overloads: dict[Any, str]) -> None:
        content = self._version.encode() + b"\n" + self._dump((self._source_stamp, overloads))
        write_sealed(Path(self._index_path), MAGIC, content)

    def _load_index(self) -> dict[Any, str]:
        path = Path(self._index_path)
        version, _, content = bytes(read_sealed(path, MAGIC) or b"").partition(b"\n")
        if version != self._version.encode():  # its signatures may be unreadable
            return {}
        match _unpickled(path, content):
            case (self._source_stamp, dict() as overloads):
                return overloads
        return {}

    def _save_data(self, name: str, data: Any) -> None:
        write_sealed(Path(self._data_path(name)), MAGIC, self._dump(data))

    def _load_data(self, name: str) -> Any:
        path = Path(self._data_path(name))
        content = read_sealed(path, MAGIC)
        return None if content is None else _unpickled(path, content)


def _unpickled(path: Path, content: bytes | memoryview) -> Any:
    """Return the saved object; None if it names what no longer exists, as after an update."""
    try:
        return pickle.loads(content)
    except Exception:  # unpickling another version's data may raise anything
        discard(path)
        return None
