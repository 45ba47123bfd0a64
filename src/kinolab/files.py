"""Atomic file writes, and cache files with checksums."""

from __future__ import annotations

import errno
import hashlib
import logging
import os
import secrets
import stat
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from kinolab.errors import printable

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

MOST_KEPT = 2**28  # [bytes] of one cache file, ten times the largest in use
LONGEST_WAIT = 60.0  # [s] for a lock; a function of ours is compiled in a tenth of that
NO_WAIT = getattr(os, "O_NONBLOCK", 0)  # opening a pipe without a writer does not block
LOG = logging.getLogger("kinolab")

DRAFT = ".draft"  # at the end of the names of files that are being written

_drafts: set[Path] = set()  # unfinished temporary files
_tidied: set[Path] = set()  # folders from which abandoned ones were removed


@contextmanager
def whole_file(path: Path) -> Iterator[BinaryIO]:
    """Open a file for writing that replaces ``path`` atomically once complete."""
    with _draft_of(path) as draft, draft.open("wb") as file:
        yield file


def write_whole(path: Path, content: bytes) -> None:
    """Write a file atomically: it appears under its name once complete."""
    with _draft_of(path) as draft:
        draft.write_bytes(content)


def write_together(files: Mapping[Path, bytes], begin: Callable[[], None]) -> None:
    """Write files that belong together: they appear under their names when all are complete.

    Args:
        files: Content by path; they appear in this order.
        begin: Called when all are complete, before the first one appears.

    Raises:
        OSError: If one cannot be written; then none of them has changed.
    """
    with ExitStack() as drafts:  # left in reverse order
        for path, content in reversed(list(files.items())):
            drafts.enter_context(_draft_of(path)).write_bytes(content)
        begin()


def stem_of(path: Path) -> str:
    """Return a file's name without its ending, for a folder of what comes of the file.

    Where nothing but dots would be left it is the whole name: ``..`` is the folder above.
    """
    return path.stem if path.stem.strip(".") else path.name


def utf_8(text: str) -> bytes:
    """Encode a text as UTF-8; lone surrogates, as of paths, become question marks."""
    return text.encode(errors="replace")


def write_sealed(path: Path, magic: bytes, content: bytes) -> None:
    """Write a cache file with a checksum; an unwritable folder is no error."""
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        write_whole(path, magic + hashlib.sha256(content).digest() + content)


def read_sealed(path: Path, magic: bytes) -> memoryview | None:
    """Return what ``write_sealed`` wrote, as a writable buffer; None if damaged or missing.

    A damaged file is removed with a warning, so that it is rebuilt only once.
    """
    try:
        kept = memoryview(read_ordinary(path, MOST_KEPT))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError as error:
        discard(path, f"cannot be read ({error.strerror})")
        return None
    begin = len(magic) + 32  # bytes of a checksum
    head, seal, content = kept[: len(magic)], kept[len(magic) : begin], kept[begin:]
    if head == magic and hashlib.sha256(content).digest() == seal:
        return content
    discard(path, "was damaged")
    return None


def touch(path: Path) -> None:
    """Note that a cache file was used; an unwritable folder is no error."""
    with suppress(OSError):
        os.utime(path)


def keep_last_used(newest: Path, most: int) -> None:
    """Remove cache files of one kind, those unused for longest first.

    Args:
        newest: One that stays; the others have its suffix and are in its folder.
        most: Size of all together in bytes, to which it leads.
    """
    with suppress(OSError):
        found = [(path, path.stat()) for path in newest.parent.glob(f"*{newest.suffix}")]
        left = sum(about.st_size for _, about in found)
        for path, about in sorted(found, key=lambda entry: entry[1].st_mtime):
            if left <= most:
                return
            if path != newest:
                path.unlink(missing_ok=True)
                left -= about.st_size


class FileLock:
    """A lock that processes share, on a file; a process that ends releases what it holds.

    Where files cannot be locked there is none, and everyone may go ahead.

    Args:
        path: Of the file, which is made, or of a folder that is there.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._handle = -1

    def acquire(self) -> bool:
        """Wait until no other process holds the lock, then take it; return whether it was taken.

        It is False if this process holds it already, after ``LONGEST_WAIT``, and without locks.
        """
        if fcntl is None or self._handle >= 0:
            return False
        handle, until = -1, time.monotonic() + LONGEST_WAIT
        with suppress(OSError):
            self._path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            flags = os.O_RDONLY if self._path.is_dir() else os.O_RDWR | os.O_CREAT
            handle = os.open(self._path, flags | NO_WAIT, 0o600)
            while time.monotonic() < until:
                try:
                    fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    time.sleep(0.01)  # [s] after which a lock is tried again
                else:
                    self._handle = handle
                    return True
        if handle >= 0:
            os.close(handle)
        return False

    def release(self) -> None:
        """Let other processes take the lock."""
        if self._handle >= 0:
            os.close(self._handle)
            self._handle = -1


@contextmanager
def only_writer(folder: Path) -> Iterator[None]:
    """Write files that belong together into a folder while no other process does."""
    lock = FileLock(folder)
    lock.acquire()
    try:
        yield
    finally:
        lock.release()


def discard(path: Path, why: str = "") -> None:
    """Remove a cache file, with a warning if a reason is given; a non-empty folder stays."""
    with suppress(OSError):
        path.rmdir() if path.is_dir() and not path.is_symlink() else path.unlink()
    if why:
        LOG.warning("warning: %s %s; it is made anew.", printable(str(path)), why)


def is_file(path: Path) -> bool:
    """Say whether there is a file of a name, which input may have given.

    There is none whose name is too long or is refused for another reason.
    """
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def read_ordinary(path: Path, most: int) -> bytearray:
    """Read a whole regular file; never blocks on a pipe or reads a device endlessly.

    Args:
        most: Largest size in bytes.

    Raises:
        OSError: If it is larger, no regular file, or cannot be read.
    """
    with open(path, "rb", opener=lambda name, flags: os.open(name, flags | NO_WAIT)) as file:
        about = os.fstat(file.fileno())
        if not stat.S_ISREG(about.st_mode):
            raise OSError(errno.EINVAL, "it is not an ordinary file")
        if about.st_size > most:
            raise OSError(errno.EFBIG, f"it is larger than {most / 1e6:g} MB")
        content = bytearray(about.st_size)
        del content[file.readinto(content) :]  # it may have shrunk meanwhile
        return content


def is_file_with(path: Path, content: bytes) -> bool:
    """Whether a regular file is there and has exactly this content."""
    try:
        return bytes(read_ordinary(path, len(content))) == content
    except OSError:  # missing, larger or no file
        return False


def discard_drafts() -> None:
    """Remove unfinished temporary files, for a process that exits early."""
    for draft in tuple(_drafts):
        with suppress(OSError):
            draft.unlink(missing_ok=True)


def discard_abandoned(folder: Path) -> None:
    """Remove the temporary files that processes left in a folder which were killed."""
    if fcntl is None:
        return
    with suppress(OSError):
        for draft in folder.glob(f".*{DRAFT}"):
            with suppress(OSError):
                handle = os.open(draft, os.O_RDWR | NO_WAIT)
                try:
                    fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)  # fails if it is at work
                    draft.unlink()
                finally:
                    os.close(handle)


@contextmanager
def _draft_of(path: Path) -> Iterator[Path]:
    """Yield an empty file in the same folder; rename it to ``path`` on success.

    It is locked for as long as this process is at work on it, so that it can be told from those
    that killed processes left. They are removed when a process first writes into their folder.
    """
    if path.parent not in _tidied:
        _tidied.add(path.parent)
        discard_abandoned(path.parent)
    handle = -1
    while handle < 0:
        draft = path.with_name(f".{path.name}.{secrets.token_hex(4)}{DRAFT}")
        _drafts.add(draft)
        try:
            handle = _locked(draft)
        except OSError:
            _drafts.discard(draft)
            raise
    try:
        yield draft
        draft.replace(path)
    except OSError as error:
        if error.errno is not None and error.filename is None:  # of a full disk
            error.filename = str(path)
        raise
    finally:
        draft.unlink(missing_ok=True)
        _drafts.discard(draft)
        os.close(handle)


def _locked(draft: Path) -> int:
    """Make a file and lock it; return its descriptor, -1 if another process just removed it."""
    handle = os.open(draft, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
    if fcntl is None:  # Windows renames no open file
        os.close(handle)
        return os.open(os.devnull, os.O_RDONLY)
    with suppress(OSError):  # there are no locks: nobody else removes it
        fcntl.flock(handle, fcntl.LOCK_EX)
    if os.fstat(handle).st_nlink:
        return handle
    os.close(handle)
    return -1
