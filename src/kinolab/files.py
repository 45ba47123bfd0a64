"""Files that are written whole or not at all."""

from __future__ import annotations

import errno
import hashlib
import logging
import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from kinolab.errors import printable

SEAL = 32  # bytes of a checksum
MOST_KEPT = 2**28  # [bytes] of what is kept in one file, ten times what there is
NO_WAIT = getattr(os, "O_NONBLOCK", 0)  # for who writes into a pipe
LOG = logging.getLogger("kinolab")

_drafts: set[Path] = set()  # what is being written, under a name that nobody looks for


@contextmanager
def whole_file(path: Path) -> Iterator[BinaryIO]:
    """Open a file that appears under its name only once it is complete."""
    with _draft_of(path) as draft, draft.open("xb") as file:
        yield file


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that it appears under its name only once it is complete."""
    with _draft_of(path) as draft:
        draft.write_bytes(content)


def utf_8(text: str) -> bytes:
    """Return what is written of a text; half a character, as of a path, becomes a question mark."""
    return text.encode(errors="replace")


def write_sealed(path: Path, magic: bytes, content: bytes) -> None:
    """Keep what can be made anew, with a checksum; a folder that cannot be written costs time."""
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        write_whole(path, magic + hashlib.sha256(content).digest() + content)


def read_sealed(path: Path, magic: bytes) -> memoryview | None:
    """Return what ``write_sealed`` kept, writable; None where it is damaged or not there.

    What is damaged is removed with a word of warning, so that it is made anew only once.
    """
    try:
        kept = memoryview(read_ordinary(path, MOST_KEPT))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError as error:
        discard(path, f"cannot be read ({error.strerror})")
        return None
    begin = len(magic) + SEAL
    head, seal, content = kept[: len(magic)], kept[len(magic) : begin], kept[begin:]
    if head == magic and hashlib.sha256(content).digest() == seal:
        return content
    discard(path, "was damaged")
    return None


def discard(path: Path, why: str = "") -> None:
    """Remove what can be made anew, and say why where it is odd; a full folder stays."""
    with suppress(OSError):
        path.rmdir() if path.is_dir() and not path.is_symlink() else path.unlink()
    if why:
        LOG.warning("warning: %s %s; it is made anew.", printable(str(path)), why)


def read_ordinary(path: Path, most: int) -> bytearray:
    """Read a file as a whole; no pipe is waited for, and no device read without end.

    Args:
        path: Of the file.
        most: Bytes that it may have.

    Raises:
        OSError: If it has more, is no ordinary file, or cannot be read.
    """
    with open(path, "rb", opener=lambda name, flags: os.open(name, flags | NO_WAIT)) as file:
        about = os.fstat(file.fileno())
        if not stat.S_ISREG(about.st_mode):
            raise OSError(errno.EINVAL, "it is not an ordinary file")
        if about.st_size > most:
            raise OSError(errno.EFBIG, f"it is larger than {most / 1e6:g} MB")
        content = bytearray(about.st_size)
        del content[file.readinto(content) :]  # it may have become shorter
        return content


def discard_drafts() -> None:
    """Remove what is half written, for a process that leaves without coming back to it."""
    for draft in tuple(_drafts):
        with suppress(OSError):
            draft.unlink(missing_ok=True)


@contextmanager
def _draft_of(path: Path) -> Iterator[Path]:
    """Give a name beside a file's own, under which it is until nothing has failed."""
    draft = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    _drafts.add(draft)
    try:
        yield draft
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)
        _drafts.discard(draft)
