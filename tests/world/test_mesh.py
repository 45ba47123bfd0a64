from __future__ import annotations

import json
import re
import struct
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Literal

import numpy as np
import pytest
import trimesh

from kinolab.errors import InputError
from kinolab.untrusted import BYTES, ELEMENTS
from kinolab.world import load_mesh, mesh_obstacle
from kinolab.world.meshes import mesh
from kinolab.world.meshes import mesh as module
from tests.support import needs

OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


def refused(path: str, root: Path) -> str:
    """Load what must be refused, and give the one mistake as a sentence."""
    with pytest.raises(InputError) as caught:
        load_mesh(path, root=root)
    (mistake,) = caught.value.mistakes
    assert mistake.where == path
    return str(mistake)


DAE = pytest.param("dae", marks=needs("collada"))


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply", "glb", "off", DAE, "STL"])
def test_every_format_gives_the_same_box(suffix: str, tmp_path: Path) -> None:
    file = tmp_path / f"box.{suffix}"
    file.write_bytes(_bytes(trimesh.creation.box((1, 2, 4)), suffix.lower()))
    loaded = load_mesh(file.name, root=tmp_path)
    assert loaded.vertices.shape == (8, 3)
    assert loaded.faces.shape == (12, 3)
    up: Literal["y", "z"] = (
        "y" if suffix == "dae" else "z"
    )  # which such files say, and are believed
    assert mesh_obstacle("box", file.name, tmp_path, up=up).warnings == ()
    np.testing.assert_array_equal(np.ptp(loaded.vertices, axis=0), [1, 2, 4])


@needs("collada")
@pytest.mark.parametrize("word", ["nan", "INF", "-inf", "1e999"])
@pytest.mark.parametrize(
    ("place", "said"),
    [
        (rb"(<float_array[^>]*>)\s*\S+", "a number in <float_array> that is not finite"),
        (rb"(<node [^>]*>)()", "a number in <translate> that is not finite"),
        (rb'(<unit meter=")[^"]*', "its unit is"),
    ],
)
def test_collada_with_numbers_that_are_not_finite_is_refused(
    place: bytes, said: str, word: str, tmp_path: Path
) -> None:
    """pycollada reads others in their place."""
    unit = b'<asset><unit meter="0.001" name="mm"/>'
    content = _bytes(trimesh.creation.box((1, 2, 4)), "dae").replace(b"<asset>", unit)
    (tmp_path / "box.dae").write_bytes(content)
    assert len(load_mesh("box.dae", root=tmp_path).faces) == 12
    wrong = word.encode()
    if b"node" in place:
        wrong = b"<translate>0 " + wrong + b" 0</translate>"
    changed = re.sub(place, lambda found: found[1] + wrong, content, count=1)
    assert changed != content
    (tmp_path / "box.dae").write_bytes(changed)
    assert said in refused("box.dae", tmp_path)


def _bytes(box: trimesh.Trimesh, kind: str) -> bytes:
    if kind == "dae":
        return bytes(trimesh.exchange.dae.export_collada(box))
    content = box.export(file_type=kind)
    return content.encode() if isinstance(content, str) else content


@pytest.mark.parametrize("path", ["mesh.zip", "mesh.fbx", "mesh", "mesh.stl.gz", "box.3mf"])
def test_other_formats_are_refused_by_name(path: str, tmp_path: Path) -> None:
    (tmp_path / path).write_bytes(b"")
    assert "STL, OBJ, PLY, GLB, OFF, DAE" in refused(path, tmp_path)


def test_a_mesh_stays_below_its_scenario(tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.mkdir()
    trimesh.creation.box().export(tmp_path / "box.stl")
    (home / "link.stl").symlink_to(tmp_path / "box.stl")
    for path in ("../box.stl", str(tmp_path / "box.stl"), "link.stl"):
        assert "outside" in refused(path, home)
    assert "does not exist" in refused("none.stl", home)
    (home / "folder.stl").mkdir()
    assert "does not exist" in refused("folder.stl", home)
    refused("nul\0.stl", home)


def test_a_link_loop_is_a_mistake(tmp_path: Path) -> None:
    (tmp_path / "loop.stl").symlink_to(tmp_path / "loop.stl")
    refused("loop.stl", tmp_path)


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply", "glb", "off", DAE])
@pytest.mark.parametrize("content", [b"", b"\0" * 100, b"garbage\n" * 30, bytes(range(256)) * 4])
def test_garbage_is_a_mistake(suffix: str, content: bytes, tmp_path: Path) -> None:
    (tmp_path / f"bad.{suffix}").write_bytes(content)
    refused(f"bad.{suffix}", tmp_path)


@pytest.mark.parametrize("suffix", ["stl", "ply", "glb", "off", "obj", DAE])
def test_a_file_cut_short_never_ends_in_a_traceback(suffix: str, tmp_path: Path) -> None:
    whole = _bytes(trimesh.creation.icosphere(subdivisions=1), suffix)
    for length in range(0, len(whole), max(1, len(whole) // 40)):
        (tmp_path / f"cut.{suffix}").write_bytes(whole[:length])
        with suppress(InputError):
            load_mesh(f"cut.{suffix}", root=tmp_path)


@pytest.mark.parametrize(
    ("name", "content", "what"),
    [
        ("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "finite"),
        ("inf.obj", "v 0 0 0\nv 1e999 0 0\nv 0 1 0\nf 1 2 3\n", "finite"),
        ("stray.off", "OFF\n4 1 0\nnan 0 0\n0 0 0\n1 0 0\n0 1 0\n3 1 2 3\n", "finite"),
        ("far.obj", "v 1e200 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "farther"),
        ("range.obj", OBJ + "f 1 2 4\n", ""),
        ("range.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", ""),
        ("negative.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", ""),
        ("points.obj", OBJ, ""),
        ("flat.obj", OBJ + "f 1 2 2\n", "three different corners"),
        ("flat2.obj", "v 0 0 0\nv 0 0 0\nv 0 1 0\nf 1 2 3\n", "three different corners"),
    ],
)
def test_unsound_meshes_are_mistakes(name: str, content: str, what: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(content)
    assert what in refused(name, tmp_path)


def test_too_large_files_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    trimesh.creation.icosphere(subdivisions=2).export(tmp_path / "ball.stl")
    monkeypatch.setitem(ELEMENTS, "triangles", 319)
    assert "more than 319 triangles" in refused("ball.stl", tmp_path)
    monkeypatch.setitem(BYTES, "mesh", 1000)
    assert "larger" in refused("ball.stl", tmp_path)


def test_instances_count_before_they_are_made(tmp_path: Path) -> None:
    """A small GLB may place one part very often."""
    scene = trimesh.Scene()
    ball = trimesh.creation.icosphere(subdivisions=5)  # 20 480 triangles
    for k in range(100):
        scene.add_geometry(
            ball, geom_name="ball", node_name=f"{k}", transform=np.diag([1.0 + k, 1, 1, 1])
        )
    (tmp_path / "many.glb").write_bytes(scene.export(file_type="glb"))
    assert "more than 2000000 triangles" in refused("many.glb", tmp_path)


def test_the_parts_of_a_scene_are_placed(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    for x in (0.0, 5.0):
        place = trimesh.transformations.translation_matrix((x, 0, 0))
        scene.add_geometry(trimesh.creation.box(), transform=place)
    (tmp_path / "two.glb").write_bytes(scene.export(file_type="glb"))
    loaded = load_mesh("two.glb", root=tmp_path)
    assert np.ptp(loaded.vertices, axis=0) == pytest.approx([6, 1, 1])


def test_textures_are_not_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "box.mtl").write_text("newmtl a\nmap_Kd /etc/hostname\n")
    (tmp_path / "box.obj").write_text("mtllib box.mtl\nusemtl a\n" + OBJ + "f 1 2 3\n")
    opened: list[str] = []

    def recorded(original: Callable[..., object]) -> Callable[..., object]:
        def record(file: str | Path, *args: object, **options: object) -> object:
            opened.append(Path(file).name)
            return original(file, *args, **options)

        return record

    store = SimpleNamespace(find=lambda _: None, keep=lambda *_: None)  # it has its own files
    monkeypatch.setattr(module, "MESHES", store)
    monkeypatch.setattr(Path, "open", recorded(Path.open))
    monkeypatch.setattr("builtins.open", recorded(open))
    assert len(load_mesh("box.obj", root=tmp_path).faces) == 1
    assert opened == ["box.obj", "box.mtl"]


def test_buffers_elsewhere_are_refused(tmp_path: Path) -> None:
    tree = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "secret.bin", "byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }
    (tmp_path / "secret.bin").write_bytes(np.eye(3, dtype=np.float32).tobytes())
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    header = struct.pack("<4sII", b"glTF", 2, 20 + len(text)) + struct.pack(
        "<I4s", len(text), b"JSON"
    )
    (tmp_path / "remote.glb").write_bytes(header + text)
    assert "GLB" in refused("remote.glb", tmp_path)


def test_an_open_mesh_and_millimetres_are_warned_about(tmp_path: Path) -> None:
    box = trimesh.creation.box((4000, 1, 1))
    box.update_faces(np.arange(12) > 0)
    box.export(tmp_path / "open.ply")
    texts = mesh_obstacle("box", "open.ply", tmp_path).warnings
    assert [("watertight" in text, "Millimetres?" in text) for text in texts] == [
        (True, False),
        (False, True),
    ]


def test_duplicate_vertices_are_merged_and_minus_zero_is_zero() -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-0.0, 0, 0], [1, 0, 0], [0, 0, 1]])
    given = np.array([[0, 1, 2], [3, 4, 5], [0, 3, 1]])
    vertices, faces, rows = mesh.merge_duplicates(corners, given)
    assert len(vertices) == 4
    np.testing.assert_array_equal(vertices[faces[1]], corners[[3, 4, 5]])
    assert rows.tolist() == [0, 1]  # the third one has no area


def test_vertices_that_no_face_uses_are_dropped(tmp_path: Path) -> None:
    (tmp_path / "stray.off").write_text("OFF\n4 1 0\n900 0 0\n0 0 0\n1 0 0\n0 1 0\n3 1 2 3\n")
    loaded = load_mesh("stray.off", root=tmp_path)
    assert loaded.vertices.max() == 1.0
    assert loaded.vertices.shape == (3, 3)
