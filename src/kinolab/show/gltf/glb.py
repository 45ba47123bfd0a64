"""Writer of binary glTF 2.0: nodes, meshes, materials and one animation.

Written here so that libraries stay independent readers: the tests read the files with trimesh and
pygltflib.

Source: The Khronos Group, glTF 2.0 Specification, 2021, sections 3 and 4.4.
"""

from __future__ import annotations

import json
import struct
from importlib.metadata import version
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.show.scene.models.ball import Color

FLOAT, UINT = 5126, 5125
VERTICES, INDICES = 34962, 34963


class Glb:
    """Builder of a glTF scene; ``to_bytes`` returns the file.

    Methods return the indices of nodes, meshes, materials and accessors.
    """

    def __init__(self) -> None:
        self._blob = bytearray()
        self._parts: dict[str, list[dict[str, Any]]] = {
            name: [] for name in ("accessors", "bufferViews", "materials", "meshes", "nodes")
        }
        self._channels: list[dict[str, Any]] = []
        self._samplers: list[dict[str, Any]] = []
        self._roots: list[int] = []

    def node(self, name: str, parent: int | None = None, **content: Any) -> int:
        """Add a node with ``mesh``, ``translation``, ``rotation`` (x, y, z, w), ``scale``.

        Of nodes with the same name the first keeps it; readers tell nodes apart by their names.
        """
        number = self._add("nodes", {"name": self._free(name), **content})
        if parent is None:
            self._roots.append(number)
        else:
            self._parts["nodes"][parent].setdefault("children", []).append(number)
        return number

    def material(self, color: Color, opacity: float = 1.0) -> int:
        """Add a matte material of an sRGB colour in 0..1."""
        surface = {
            "baseColorFactor": [*map(_linear, color), opacity],
            "metallicFactor": 0.0,
            "roughnessFactor": 0.85,
        }
        mixed = {"alphaMode": "BLEND"} if opacity < 1.0 else {}
        content = {"pbrMetallicRoughness": surface, "doubleSided": True, **mixed}
        known = self._parts["materials"]
        return known.index(content) if content in known else self._add("materials", content)

    def mesh(self, name: str, primitives: list[dict[str, Any]]) -> int:
        """Add a mesh of primitives."""
        return self._add("meshes", {"name": name, "primitives": primitives})

    def points(self, vertices: Array) -> int:
        """Store vertices of shape (n, 3) in [m]."""
        table = np.asarray(vertices, dtype=np.float32)
        extent = {"min": table.min(axis=0).tolist(), "max": table.max(axis=0).tolist()}
        return self._accessor(table, FLOAT, VERTICES, extent)

    def primitive(self, points: int, rows: NDArray[Any], material: int) -> dict[str, Any]:
        """Return triangles, shape (m, 3), or segments, shape (m, 2), between stored vertices."""
        indices = self._accessor(rows.astype(np.uint32).reshape(-1, 1), UINT, INDICES, {})
        parts = {"attributes": {"POSITION": points}, "indices": indices, "material": material}
        # Lines and triangles, by the vertices of each.
        return {**parts, "mode": {2: 1, 3: 4}[rows.shape[1]]}

    def animate(self, node: int, what: str, times: Array, values: Array) -> None:
        """Animate ``translation``, ``rotation`` or ``scale`` of a node by keys (nk, 3 or 4).

        A single key is where the node is, and no animation.
        """
        if len(times) < 2:
            return
        t = np.asarray(times, dtype=np.float32)
        extent = {"min": [float(t.min())], "max": [float(t.max())]}
        sampler = {
            "input": self._accessor(t[:, None], FLOAT, None, extent),
            "output": self._accessor(np.asarray(values, dtype=np.float32), FLOAT, None, {}),
            "interpolation": "LINEAR",
        }
        self._samplers.append(sampler)
        target = {"node": node, "path": what}
        self._channels.append({"sampler": len(self._samplers) - 1, "target": target})

    def to_bytes(self) -> bytes:
        """Return the file."""
        data = bytes(self._blob)
        content: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": f"kinolab {version('kinolab')}"},
            "scene": 0,
            "scenes": [{"nodes": self._roots}],
            "buffers": [{"byteLength": len(data)}],
            **{name: part for name, part in self._parts.items() if part},
        }
        if self._channels:
            animation = {"name": "plan", "channels": self._channels, "samplers": self._samplers}
            content["animations"] = [animation]
        text = json.dumps(content, separators=(",", ":"), allow_nan=False).encode()
        chunks = _chunk(b"JSON", text, b" ") + _chunk(b"BIN\0", data, b"\0")
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    def _free(self, name: str) -> str:
        taken = {node["name"] for node in self._parts["nodes"]}
        others = (f"{name} ({k})" for k in count(2))
        return name if name not in taken else next(other for other in others if other not in taken)

    def _add(self, kind: str, content: dict[str, Any]) -> int:
        self._parts[kind].append(content)
        return len(self._parts[kind]) - 1

    def _accessor(
        self, table: NDArray[Any], kind: int, target: int | None, extent: dict[str, Any]
    ) -> int:
        data = table.astype("<f4" if kind == FLOAT else "<u4").tobytes()
        view = {"buffer": 0, "byteOffset": len(self._blob), "byteLength": len(data)}
        self._blob += data
        use = {} if target is None else {"target": target}
        where = {"bufferView": self._add("bufferViews", view | use)}
        shape = {"count": len(table), "type": {1: "SCALAR", 3: "VEC3", 4: "VEC4"}[table.shape[1]]}
        return self._add("accessors", {**where, "componentType": kind, **shape, **extent})


def _chunk(kind: bytes, data: bytes, filler: bytes) -> bytes:
    padded = data + filler * (-len(data) % 4)
    return struct.pack("<I4s", len(padded), kind) + padded


def _linear(value: float) -> float:
    """Return an sRGB value in linear light. Source: IEC 61966-2-1, 1999."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
