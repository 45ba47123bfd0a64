"""Files that are written whole or not at all."""

from __future__ import annotations

import hashlib
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

SEAL = 32  # bytes of a checksum

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


def write_sealed(path: Path, magic: bytes, content: bytes) -> None:
    """Keep what can be made anew, with a checksum; a folder that cannot be written costs time."""
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        write_whole(path, magic + hashlib.sha256(content).digest() + content)


def read_sealed(path: Path, magic: bytes) -> memoryview | None:
    """Return what ``write_sealed`` kept, writable; None where it is damaged or not there."""
    try:
        with path.open("rb") as file:
            kept = memoryview(bytearray(path.stat().st_size))
            file.readinto(kept)
    except OSError:
        return None
    begin = len(magic) + SEAL
    head, seal, content = kept[: len(magic)], kept[len(magic) : begin], kept[begin:]
    return content if head == magic and hashlib.sha256(content).digest() == seal else None


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
