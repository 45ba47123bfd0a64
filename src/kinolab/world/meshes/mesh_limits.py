"""What a mesh file may be large for, looked at before anything is built of it.

How much that is, ``untrusted`` says.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any

from kinolab.errors import InputError, Mistake, printable
from kinolab.untrusted import BYTES, ELEMENTS, json_of, refuse_large, refuse_many

JOIN = "Join parts before you export it."
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
COLLADA_NUMBERS = ("float_array", "lookat", "matrix", "rotate", "scale", "skew", "translate")
COLLADA_UNREAD = ("library_animations", "library_controllers")
MATERIAL = re.compile(rb"^[ \t]*+usemtl([^\r\n]*+)", re.MULTILINE)


def require_size(where: str, kind: str, content: bytes) -> None:
    """Refuse a file that would take too much memory or time.

    Args:
        where: What the file is called in messages.
        kind: Its format, in small letters.

    Raises:
        InputError: If it is too large for what it is.
        ValueError: If it is no file of this format.
    """
    if kind == "glb":
        _require_small_scene(where, content)
        return
    binary = kind == "ply" and b"format ascii" not in content[: content.find(b"end_header")]
    if f"mesh in {kind}" in BYTES and not binary:
        remedy = "As text, it may have no more. Simplify the mesh, or save it as GLB."
        refuse_large(len(content), f"mesh in {kind}", where, remedy)
    if kind == "stl":
        remedy = "Join them, or save it as binary STL."
        refuse_many(content.count(b"endsolid"), "solids", where, remedy)
    if kind == "obj" and content.count(b"usemtl") > ELEMENTS["materials"]:  # far fewer differ
        refuse_many(len(set(MATERIAL.findall(content))), "materials", where, JOIN)
    if kind == "dae":
        refuse_many(unfolded_nodes(content), "nodes", where, JOIN)
        _require_finite(where, content)


def unfolded_nodes(content: bytes) -> int:
    """Return how many nodes a DAE has once each instance of a node stands for all that is in it.

    Thirty nodes that hold the one before twice make a billion. A node within itself makes
    infinitely many. What is more than a file may have is not counted on.

    Raises:
        ParseError: If it is no XML.
    """
    from xml.etree import ElementTree  # late: other files than DAE are not XML

    held: dict[str, list[str]] = {"": []}
    around, made = [""], 0
    for event, element in ElementTree.iterparse(io.BytesIO(content), ("start", "end")):
        name = str(element.tag).rpartition("}")[2]
        if event == "start" and name == "node":
            made += 1
            own = element.get("id") or f"node {made}"
            held[around[-1]].append(own)
            held.setdefault(own, [])
            around.append(own)
        elif event == "start" and name == "instance_node":
            held[around[-1]].append(element.get("url", "").removeprefix("#"))
        elif event == "end":
            if name == "node":
                around.pop()
            element.clear()
    count, left = 0, list(held[""])
    while left and count + len(left) <= ELEMENTS["nodes"]:
        count += 1
        left += held.get(left.pop(), ())
    return count + len(left)


def _require_finite(where: str, content: bytes) -> None:
    """Refuse a DAE with numbers that are not finite, for which pycollada takes others.

    What moves and bends is not read, and may have any.

    Raises:
        InputError: If there is one.
        ValueError: If a place of numbers has something else.
    """
    from xml.etree import ElementTree  # late, as above

    unread = 0
    for event, element in ElementTree.iterparse(io.BytesIO(content), ("start", "end")):
        name = str(element.tag).rpartition("}")[2]
        unread += (event == "start") - (event == "end") if name in COLLADA_UNREAD else 0
        if event == "start":
            continue
        numbers = (element.text or "").split() if name in COLLADA_NUMBERS and not unread else ()
        if not all(map(math.isfinite, map(float, numbers))):
            what = f"has a number in <{name}> that is not finite."
            raise InputError([Mistake(where, what, "Export it again.")])
        if name == "unit":
            _require_unit(where, element.get("meter", "1"))
        element.clear()


def _require_unit(where: str, text: str) -> None:
    """Refuse a unit of length that is none.

    Raises:
        InputError: If it is no positive, finite number.
    """
    with suppress(ValueError):
        if 0.0 < float(text) < math.inf:
            return
    what = f"says that its unit is {printable(text)!r} m."
    raise InputError([Mistake(where, what, "Give a positive number, such as 0.001 for 1 mm.")])


def _require_small_scene(where: str, content: bytes) -> None:
    """Look at the JSON of a GLB: a kilobyte of it may ask for a terabyte of zeros."""
    length = int.from_bytes(content[12:16], "little")
    if content[:4] != b"glTF" or content[16:20] != b"JSON" or length > len(content):
        raise ValueError("it does not begin as a GLB does")
    refuse_large(length, "scene in glb", where, "That is the JSON in it. Simplify the mesh.")
    scene = json_of(content[20 : 20 + length])
    if not isinstance(scene, dict):
        raise ValueError("its JSON is no table")
    nodes = _list(scene, "nodes")
    parts = sum(len(_list(mesh, "primitives")) for mesh in _list(scene, "meshes"))
    refuse_many(max(len(nodes), parts), "nodes", where, JOIN)
    refuse_many(_deepest(nodes), "levels of nodes", where, "Flatten them before you export it.")
    empty = sum(_empty_bytes(scene))
    if empty > BYTES["zeros in glb"]:
        what = f"asks for {empty / 1e6:.0f} MB of zeros that are not in it."
        raise InputError([Mistake(where, what, "Export it again.")])


def _list(holder: object, key: str) -> list[Any]:
    found = holder.get(key) if isinstance(holder, dict) else None
    return found if isinstance(found, list) else []


def _deepest(nodes: Sequence[Any]) -> int:
    """Return within how many others a node of a GLB is at most; a node in itself is in many."""
    above: dict[int, int] = {}
    for k, node in enumerate(nodes):
        above |= {child: k for child in _list(node, "children") if isinstance(child, int)}
    depth = [0] * len(nodes)
    for _ in range(ELEMENTS["levels of nodes"] + 1):  # each round carries depths one node further
        changed = False
        for child, parent in above.items():
            if 0 <= child < len(depth) and depth[child] <= depth[parent]:
                depth[child], changed = depth[parent] + 1, True
        if not changed:
            break
    return max(depth, default=0)


def _empty_bytes(scene: Mapping[str, Any]) -> Iterator[int]:
    for accessor in _list(scene, "accessors"):
        if isinstance(accessor, dict) and "bufferView" not in accessor:
            count, kind = accessor.get("count"), accessor.get("type")
            if not isinstance(count, int):  # a list would be taken as a shape
                raise ValueError("an accessor's count is no whole number")
            if isinstance(kind, str):
                yield max(count, 0) * COMPONENTS.get(kind, 16) * 4  # bytes at most
