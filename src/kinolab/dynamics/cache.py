"""Compiled machines on disk, by content: what a machine is, for which processor, by which code.

An entry that does not match its own checksum is built anew; it is never trusted.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import platformdirs

from kinolab.dynamics.compilation import processor
from kinolab.files import write_whole

MAGIC = b"kinolab object 1\n"


def folder() -> Path:
    """Return where compiled machines are kept; the variable KINOLAB_CACHE overrides it."""
    override = os.environ.get("KINOLAB_CACHE")
    return Path(override) if override else platformdirs.user_cache_path("kinolab")


def cached(
    content: str, build: Callable[[], tuple[dict[str, Any], bytes]]
) -> tuple[dict[str, Any], bytes]:
    """Return the facts and machine code of a machine, built only where they are not on disk.

    Args:
        content: The machine as text, all of it.
        build: Makes facts (JSON) and code.
    """
    path = folder() / f"{_key(content)}.machine"
    entry = _read(path)
    if entry is None:
        entry = build()
        _write(path, *entry)
    return entry


def _key(content: str) -> str:
    parts = (content, processor(), _own_code())
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


@cache
def _own_code() -> str:
    """Return a digest of the code that derives and compiles: a change of it is another machine."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _read(path: Path) -> tuple[dict[str, Any], bytes] | None:
    """Return an entry, None where there is none or it is damaged."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    head, rest = content[: len(MAGIC)], content[len(MAGIC) :]
    digest, payload = rest[:32], rest[32:]
    if head != MAGIC or hashlib.sha256(payload).digest() != digest:
        return None
    facts, _, code = payload.partition(b"\0")
    loaded: dict[str, Any] = json.loads(facts)
    return loaded, code


def _write(path: Path, facts: dict[str, Any], code: bytes) -> None:
    """Keep an entry; a folder that cannot be written only costs time."""
    payload = json.dumps(facts).encode() + b"\0" + code
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        write_whole(path, MAGIC + hashlib.sha256(payload).digest() + payload)
