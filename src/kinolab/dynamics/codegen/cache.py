"""Compiled machines on disk, by content: what a machine is, for which processor, by which code.

An entry that does not match its own checksum is built anew; it is never trusted.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import platformdirs

from kinolab.dynamics.codegen.llvm_jit import processor
from kinolab.files import read_sealed, write_sealed

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
        facts, code = entry
        write_sealed(path, MAGIC, json.dumps(facts).encode() + b"\0" + code)
    return entry


def code_in(folder: Path) -> str:
    """Return a digest of the code below a folder: any change of it makes another thing."""
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _key(content: str) -> str:
    parts = (content, processor(), _own_code())
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


@cache
def _own_code() -> str:
    return code_in(Path(__file__).parents[1])  # it derives and compiles


def _read(path: Path) -> tuple[dict[str, Any], bytes] | None:
    """Return an entry, None where there is none or it is damaged."""
    content = read_sealed(path, MAGIC)
    if content is None:
        return None
    facts, _, code = bytes(content).partition(b"\0")
    loaded: dict[str, Any] = json.loads(facts)
    return loaded, code
