"""Files that are written whole or not at all."""

from __future__ import annotations

import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

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
