"""Four mesh formats, written so that the same mesh gives the same bytes everywhere."""

from __future__ import annotations

import json

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Vertices = NDArray[np.float32]
Faces = NDArray[np.int64]

DECIMALS = 5  # of a coordinate in a file: coarser than what sin and cos differ by between machines


def encode(vertices: Array, faces: Faces, suffix: str) -> bytes:
    """Return the bytes of a .stl, .ply, .obj or .glb file.

    Args:
        vertices: Points in the file's unit, shape (n, 3).
        faces: Three vertices each, shape (m, 3).
        suffix: How the file's name ends, with the dot.
    """
    writers = {".stl": stl, ".ply": ply, ".obj": obj, ".glb": glb}
    points = (vertices.round(DECIMALS) + 0.0).astype("<f4")  # -0.0 becomes 0.0
    return writers[suffix](points, faces)


def stl(vertices: Vertices, faces: Faces) -> bytes:
    """Return a binary STL file: a blank remark of 80 bytes, then a normal and corners per face."""
    corners = vertices[faces]
    layout = [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("remark", "<u2")]
    table = np.zeros(len(faces), dtype=layout)
    table["normal"], table["corners"] = _normals(corners), corners
    return bytes(80) + _uint32(len(faces)) + table.tobytes()


def ply(vertices: Vertices, faces: Faces) -> bytes:
    """Return a binary PLY file."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    table = np.zeros(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    table["count"], table["corners"] = 3, faces
    return header.encode() + vertices.tobytes() + table.tobytes()


def obj(vertices: Vertices, faces: Faces) -> bytes:
    """Return an OBJ file, which is text and counts from 1."""
    points = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in vertices.tolist()]
    triangles = [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
    return "\n".join([*points, *triangles, ""]).encode()


def glb(vertices: Vertices, faces: Faces) -> bytes:
    """Return a binary glTF file with one mesh.

    Source: glTF 2.0 Specification, section 4.4 (GLB); 5126 is float, 5125 unsigned int.
    """
    points, corners = vertices.tobytes(), faces.astype("<u4").tobytes()
    low, high = vertices.min(axis=0).tolist(), vertices.max(axis=0).tolist()
    places = {"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3"}
    indices = {"bufferView": 1, "componentType": 5125, "count": faces.size, "type": "SCALAR"}
    scene = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{**places, "min": low, "max": high}, indices],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(points)},
            {"buffer": 0, "byteOffset": len(points), "byteLength": len(corners)},
        ],
        "buffers": [{"byteLength": len(points) + len(corners)}],
    }
    chunks = _chunk(b"JSON", json.dumps(scene).encode(), b" ")
    chunks += _chunk(b"BIN\0", points + corners, b"\0")
    return b"glTF" + _uint32(2) + _uint32(12 + len(chunks)) + chunks


def _chunk(kind: bytes, content: bytes, filler: bytes) -> bytes:
    content += filler * (-len(content) % 4)
    return _uint32(len(content)) + kind + content


def _uint32(number: int) -> bytes:
    return number.to_bytes(4, "little")


def _normals(corners: Vertices) -> Vertices:
    a, b, c = (corners[:, k].astype(np.float64) for k in range(3))
    normal = np.cross(b - a, c - a)
    unit: Vertices = (normal / np.linalg.norm(normal, axis=1, keepdims=True) + 0.0).astype("<f4")
    return unit
