"""What a mesh file may be large for, looked at before anything is built of it.

Parsers of text make objects of all words of a file: in trimesh, an ASCII PLY takes 75 bytes of
memory for each of its own, and a DAE 90. The largest sizes keep them all below
``untrusted.MOST_MEMORY``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from kinolab.errors import InputError, Mistake
from kinolab.untrusted import json_of

MAX_BYTES = 200_000_000
MAX_TEXT_BYTES = {"dae": 40_000_000, "off": 50_000_000, "ply": 50_000_000, "obj": 100_000_000}
MAX_SOLIDS = 1000  # of an STL of text; each takes a millisecond
MAX_SCENE_BYTES = 20_000_000  # of the JSON in a GLB
MAX_EMPTY_BYTES = 100_000_000  # of a GLB's arrays that are not in the file: they are zero
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
COMPONENT_BYTES = 4  # at most


def require_size(where: str, kind: str, content: bytes) -> None:
    """Refuse a file that would take too much memory or time.

    Args:
        where: What the file is called in messages.
        kind: Its format, in small letters.
        content: Of the file.

    Raises:
        InputError: If it is too large for what it is.
        ValueError: If it is no file of this format.
    """
    if kind == "glb":
        _require_small_scene(where, content)
        return
    binary = kind == "ply" and b"format ascii" not in content[: content.find(b"end_header")]
    most = MAX_BYTES if binary else MAX_TEXT_BYTES.get(kind, MAX_BYTES)
    if len(content) > most:
        raise _too_large(where, most, "As text, it may have no more. ")
    if kind == "stl" and content.count(b"endsolid") > MAX_SOLIDS:
        what = f"has more than {MAX_SOLIDS} solids."
        raise InputError([Mistake(where, what, "Join them, or save it as binary STL.")])


def _too_large(where: str, most: int, why: str = "") -> InputError:
    what = f"is larger than {most // 10**6} MB."
    return InputError([Mistake(where, what, f"{why}Simplify the mesh, or save it as GLB.")])


def _require_small_scene(where: str, content: bytes) -> None:
    """Look at the JSON of a GLB: a kilobyte of it may ask for a terabyte of zeros."""
    length = int.from_bytes(content[12:16], "little")
    if content[:4] != b"glTF" or content[16:20] != b"JSON" or length > len(content):
        raise ValueError("it does not begin as a GLB does")
    if length > MAX_SCENE_BYTES:
        raise _too_large(where, MAX_SCENE_BYTES, "That is the JSON in it. ")
    scene = json_of(content[20 : 20 + length])
    empty = sum(_empty_bytes(scene if isinstance(scene, dict) else {}))
    if empty > MAX_EMPTY_BYTES:
        what = f"asks for {empty / 1e6:.0f} MB of zeros that are not in it."
        raise InputError([Mistake(where, what, "Export it again.")])


def _empty_bytes(scene: Mapping[str, Any]) -> Iterator[int]:
    accessors = scene.get("accessors")
    for accessor in accessors if isinstance(accessors, list) else []:
        if isinstance(accessor, dict) and "bufferView" not in accessor:
            count, kind = accessor.get("count"), accessor.get("type")
            if isinstance(count, int) and isinstance(kind, str):
                yield max(count, 0) * COMPONENTS.get(kind, 16) * COMPONENT_BYTES
