"""Compiled machines on disk: what a machine is, for which processor, by which code."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, TypeAlias

from kinolab.dynamics.codegen.llvm_jit import compile_ir, processor
from kinolab.dynamics.codegen.methods import METHODS
from kinolab.store import Kind, code_in, digest_of

Compiled: TypeAlias = tuple[dict[str, Any], bytes]  # facts (JSON), and machine code


def key_of(content: str) -> str:
    """Return what stands for a machine as text, this processor, and the code that compiles it."""
    methods = map(repr, METHODS.values())
    return digest_of(content, processor(), code_in(Path(__file__).parents[1]), *methods)


def compiled(text: str, *, quick: bool = False) -> bytes:
    """Return the object code of a module of LLVM IR, compiled only where it is not on disk.

    Values of parameters are arguments of the code: machines that differ in them alone have one.

    Args:
        quick: As ``compile_ir`` takes it.
    """
    return OBJECTS.get([key_of(text)], lambda: compile_ir(text, quick=quick))


def _pack(compiled: Compiled) -> bytes:
    facts, code = compiled
    return json.dumps(facts).encode() + b"\0" + code


def _unpack(content: memoryview) -> Compiled:
    facts, _, code = bytes(content).partition(b"\0")
    return dict(json.loads(facts)), code


COMPILED = Kind("machine", _pack, _unpack)  # by the ``key_of`` a machine
OBJECTS: Kind[bytes] = Kind("object", bytes, bytes)  # by that of its IR
