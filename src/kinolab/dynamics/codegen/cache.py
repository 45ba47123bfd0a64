"""Compiled machines on disk, by content: what a machine is, for which processor, by which code.

An entry that does not match its own checksum is built anew; it is never trusted.
"""

from __future__ import annotations

import hashlib
import json
import os
import pickle
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import platformdirs

from kinolab.dynamics.codegen.llvm_jit import compile_ir, processor
from kinolab.files import discard, read_sealed, write_sealed

MAGIC = b"kinolab object 1\n"
RECORD_MAGIC = b"kinolab record 1\n"


def folder() -> Path:
    """Return where compiled machines are kept; the variable KINOLAB_CACHE overrides it."""
    override = os.environ.get("KINOLAB_CACHE")
    return Path(override) if override else platformdirs.user_cache_path("kinolab")


def cached(
    key: str, build: Callable[[], tuple[dict[str, Any], bytes]]
) -> tuple[dict[str, Any], bytes]:
    """Return the facts and machine code of a machine, built only where they are not on disk.

    Args:
        key: The ``key_of`` the machine as text, all of it.
        build: Makes facts (JSON) and code.
    """
    path = folder() / f"{key}.machine"
    entry = _read(path)
    if entry is None:
        entry = build()
        facts, code = entry
        write_sealed(path, MAGIC, json.dumps(facts).encode() + b"\0" + code)
    return entry


def compiled(text: str) -> bytes:
    """Return the object code of a module of LLVM IR, compiled only where it is not on disk.

    Values of parameters are arguments of the code: machines that differ in them alone have one.
    """
    path = folder() / f"{key_of(text)}.object"
    code = read_sealed(path, MAGIC)
    if code is None:
        made = compile_ir(text)
        write_sealed(path, MAGIC, made)
        return made
    return bytes(code)


def read_record(key: str) -> Any:
    """Return what was kept by ``write_record``; None where there is none or it is damaged."""
    path = _record_path(key)
    content = read_sealed(path, RECORD_MAGIC)
    if content is None:
        return None
    try:
        return pickle.loads(content)
    except Exception:  # unpickling what another version wrote may raise anything
        discard(path)
        return None


def write_record(key: str, record: Any) -> None:
    """Keep plain data on disk under a ``key_of`` all that determines it."""
    write_sealed(_record_path(key), RECORD_MAGIC, pickle.dumps(record))


def _record_path(key: str) -> Path:
    return folder() / f"{key}.record"


def code_in(*places: Path) -> str:
    """Return a digest of the code in files and below folders: any change makes another thing."""
    digest = hashlib.sha256()
    for place in places:
        for path in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            digest.update(path.read_bytes())
    return digest.hexdigest()


def key_of(content: str) -> str:
    """Return what stands for a machine as text, this processor, and the code that compiles it."""
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
    try:
        loaded = json.loads(facts)
    except (ValueError, RecursionError):
        loaded = None
    if not isinstance(loaded, dict):
        discard(path, "was damaged")
        return None
    return loaded, code
