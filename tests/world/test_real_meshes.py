"""Meshes as other programs write them: sides, units, axes and colours; each is made here."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from kinolab.dynamics.language.shapes import Sphere
from kinolab.errors import InputError
from kinolab.numerics.arrays import Array
from kinolab.world import BodyGeometry, CollisionChecker, World, load_mesh, mesh_obstacle
from kinolab.world.meshes.double_faces import single_faces
from kinolab.world.meshes.mesh_reading import UNPAINTED
from tests.support import needs

DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="inch" meter="0.0254"/><up_axis>Y_UP</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="t"><lambert>
<diffuse><color>1 0.5 0 1</color></diffuse></lambert></technique></profile_COMMON></effect>
</library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="9">0 0 0 4 0 0 0 2 0</float_array><technique_common>
<accessor source="#a" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="2" material="s"><input semantic="VERTEX" source="#v" offset="0"/>
<p>0 1 2 2 1 0</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s1"><node><instance_geometry url="#g"><bind_material>
<technique_common><instance_material symbol="s" target="#m"/></technique_common></bind_material>
</instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s1"/></scene></COLLADA>
"""


def two_sided(shape: trimesh.Trimesh) -> trimesh.Trimesh:
    """Every triangle of a mesh once for each side, in no order."""
    faces = np.concatenate([shape.faces, shape.faces[:, [2, 1, 0]]])
    np.random.default_rng(0).shuffle(faces)
    return trimesh.Trimesh(shape.vertices, faces, process=False)


def test_a_box_of_two_sides_is_read_once_and_said(tmp_path: Path) -> None:
    two_sided(trimesh.creation.box((1, 2, 3))).export(tmp_path / "box.ply")
    obstacle = mesh_obstacle("box", "box.ply", tmp_path)
    assert len(obstacle.faces) == 12
    (warning,) = obstacle.warnings
    assert warning.startswith("box.ply: has all of its triangles twice, facing both ways")
    assert not obstacle.solid  # nothing says which side is full


def test_two_sides_that_are_called_solid_are_filled(tmp_path: Path) -> None:
    two_sided(trimesh.creation.icosphere(radius=2.0)).export(tmp_path / "ball.ply")
    bead = BodyGeometry("bead", (Sphere(0.1),))
    inside = np.eye(3, 4)[None]
    for solid in (None, True):
        obstacle = mesh_obstacle("ball", "ball.ply", tmp_path, solid=solid)
        assert CollisionChecker([bead], World((obstacle,))).collides(inside) is bool(solid)
    corners = obstacle.vertices[obstacle.faces]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume == pytest.approx(4 / 3 * np.pi * 8, rel=0.05)  # all faces look outward


def test_a_hole_in_a_surface_of_two_sides_is_found(tmp_path: Path) -> None:
    box = trimesh.creation.box()
    box.update_faces(np.arange(12) > 0)
    two_sided(box).export(tmp_path / "open.ply")
    with pytest.raises(InputError, match="not watertight, so it cannot be solid"):
        mesh_obstacle("open", "open.ply", tmp_path, solid=True)


def test_a_wall_between_two_chambers_stays(tmp_path: Path) -> None:
    """Two boxes side by side have the square between them twice, and enclose space."""
    boxes = [trimesh.creation.box(), trimesh.creation.box().apply_translation((1, 0, 0))]
    trimesh.util.concatenate(boxes).export(tmp_path / "two.ply")
    obstacle = mesh_obstacle("two", "two.ply", tmp_path)
    assert obstacle.solid
    assert obstacle.warnings == ()
    assert len(obstacle.faces) == 24


def test_copies_are_left_out_and_counted(tmp_path: Path) -> None:
    box = trimesh.creation.box()
    faces = np.concatenate([box.faces, np.roll(box.faces[:5], 1, axis=1)])
    trimesh.Trimesh(box.vertices, faces, process=False).export(tmp_path / "box.ply")
    obstacle = mesh_obstacle("box", "box.ply", tmp_path)
    assert obstacle.solid
    assert len(obstacle.faces) == 12
    assert obstacle.warnings == (
        "box.ply: has 5 triangles more than once; the copies are left out.",
    )


def test_surfaces_of_one_side_only_are_left_as_they_are() -> None:
    """On a Moebius strip no triangles can agree."""
    n = 12
    turn = 2 * np.pi * np.arange(n) / n
    edge = np.stack(
        [np.cos(turn / 2) * np.cos(turn), np.cos(turn / 2) * np.sin(turn), np.sin(turn / 2)]
    )
    middle = np.stack([np.cos(turn), np.sin(turn), 0 * turn])
    vertices = np.concatenate([(3 * middle + edge).T, (3 * middle - edge).T])
    nexts = [(k + 1) % n + (n if k == n - 1 else 0) for k in range(n)]  # it closes upside down
    opposite = [(k + 1) % n + (0 if k == n - 1 else n) for k in range(n)]
    faces = [(k, nexts[k], k + n) for k in range(n)]
    faces += [(nexts[k], opposite[k], k + n) for k in range(n)]
    once = np.array(faces)
    found = single_faces(vertices, np.concatenate([once, once[:, ::-1]]))
    assert found.pairs == len(found.faces) == 2 * n
    assert found.both.all()


@needs("collada")
def test_collada_says_its_unit_its_axis_and_its_colour(tmp_path: Path) -> None:
    (tmp_path / "wedge.dae").write_text(DAE)
    obstacle = mesh_obstacle("wedge", "wedge.dae", tmp_path)
    assert len(obstacle.faces) == 1
    assert np.ptp(obstacle.vertices, axis=0) == pytest.approx([4, 2, 0])  # nothing is changed
    sides, unit, up = obstacle.warnings
    assert "twice" in sides
    assert unit == "wedge.dae: says that its unit is 0.0254 m. Then write scale = 0.0254."
    assert up == 'wedge.dae: says that its y axis points up. Then write up = "y".'
    assert obstacle.colors is not None
    np.testing.assert_allclose(obstacle.colors, [[1.0, 0.5, 0.0]], atol=1 / 255)
    heeded = mesh_obstacle("wedge", "wedge.dae", tmp_path, scale=0.0254, up="y")
    assert len(heeded.warnings) == 1


def test_collada_without_its_reader_names_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "wedge.dae").write_text(DAE)
    monkeypatch.setitem(sys.modules, "collada", None)
    monkeypatch.setenv("KINOLAB_CACHE", str(tmp_path / "cache"))
    with pytest.raises(InputError, match=r"pip install 'kinolab\[collada\]'"):
        load_mesh("wedge.dae", root=tmp_path)


@pytest.mark.parametrize("kind", ["glb", "ply", "obj"])
def test_colours_are_kept(kind: str, tmp_path: Path) -> None:
    """A red and a blue box, the blue one first merged to fewer vertices."""
    boxes = [trimesh.creation.box(), trimesh.creation.box().apply_translation((5, 0, 0))]
    for box, color in zip(boxes, ([200, 0, 0, 255], [0, 0, 200, 255]), strict=True):
        box.visual.vertex_colors = np.tile(np.array(color, np.uint8), (8, 1))
    trimesh.util.concatenate(boxes).export(tmp_path / f"two.{kind}")
    obstacle = mesh_obstacle("two", f"two.{kind}", tmp_path)
    assert obstacle.colors is not None
    side = obstacle.vertices[obstacle.faces].mean(axis=1)[:, 0] > 2.5
    expected = np.where(side[:, None], [0, 0, 200 / 255], [200 / 255, 0, 0])
    np.testing.assert_allclose(obstacle.colors, expected, atol=0.01)


MATERIALS = "newmtl dark grey\nKd 0.4 0.4 0.4\n\nnewmtl red\nKd 1 0 0\nmap_Kd /etc/hostname\n"
PAINTED = """# made here
mtllib {library}
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
usemtl dark grey
f 1 3 2
usemtl red
f 1 2 4
usemtl nowhere
f 1 4 3
"""


def painted(folder: Path, library: str) -> Array | None:
    """The colours of three triangles: one in the plane z = 0, one in y = 0, one in x = 0."""
    (folder / "corner.obj").write_text(PAINTED.format(library=library))
    obstacle = mesh_obstacle("corner", "corner.obj", folder)
    if obstacle.colors is None:
        return None
    extent = np.ptp(obstacle.vertices[obstacle.faces], axis=1)
    return obstacle.colors[[np.flatnonzero(extent[:, axis] == 0.0)[0] for axis in (2, 1, 0)]]


def test_the_materials_of_an_obj_give_it_colours(tmp_path: Path) -> None:
    (tmp_path / "my colours.mtl").write_text(MATERIALS)
    colors = painted(tmp_path, "my colours.mtl")
    assert colors is not None
    np.testing.assert_allclose(colors[0], 0.4, atol=1 / 255)
    np.testing.assert_allclose(colors[1], [1.0, 0.0, 0.0], atol=1 / 255)
    np.testing.assert_allclose(colors[2], UNPAINTED / 255, atol=1 / 255)


def test_other_materials_of_the_same_obj_are_seen(tmp_path: Path) -> None:
    """The mesh that was kept is of the OBJ and its materials, not of the OBJ alone."""
    assert painted(tmp_path, "a.mtl") is None  # it is not there
    (tmp_path / "a.mtl").write_text(MATERIALS)
    assert painted(tmp_path, "a.mtl") is not None
    (tmp_path / "a.mtl").write_text(MATERIALS.replace("1 0 0", "0 1 0"))
    colors = painted(tmp_path, "a.mtl")
    assert colors is not None
    np.testing.assert_allclose(colors[1], [0.0, 1.0, 0.0], atol=1 / 255)


@pytest.mark.parametrize("name", ["../outside.mtl", "link.mtl", "a.txt", "folder.mtl", "\0.mtl"])
def test_materials_from_elsewhere_are_not_read(name: str, tmp_path: Path) -> None:
    home = tmp_path / "home"
    (home / "folder.mtl").mkdir(parents=True)
    (tmp_path / "outside.mtl").write_text(MATERIALS)
    (home / "link.mtl").symlink_to(tmp_path / "outside.mtl")
    (home / "a.txt").write_text(MATERIALS)
    assert painted(home, name) is None


def test_a_scan_has_few_colours_left(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(subdivisions=3)
    rng = np.random.default_rng(0)
    ball.visual.vertex_colors = rng.integers(0, 255, (len(ball.vertices), 4), dtype=np.uint8)
    ball.export(tmp_path / "scan.ply")
    obstacle = mesh_obstacle("scan", "scan.ply", tmp_path)
    assert obstacle.colors is not None
    assert 8 <= len(np.unique(obstacle.colors, axis=0)) <= 32


def test_a_mesh_on_its_side_is_suspected_from_its_world(tmp_path: Path) -> None:
    trimesh.creation.box((20, 1, 30)).export(tmp_path / "hall.ply")
    bounds = {"x": (-10.0, 10.0), "y": (-15.0, 15.0)}
    lying = World((mesh_obstacle("hall", "hall.ply", tmp_path),), bounds=bounds)
    (warning,) = lying.warnings
    assert warning == (
        "hall: is 20 x 1 x 30 m in a world of 20 x 30 m, as if y pointed up in its file. "
        'Then write up = "y".'
    )
    standing = World((mesh_obstacle("hall", "hall.ply", tmp_path, up="y"),), bounds=bounds)
    assert standing.warnings == ()


@pytest.mark.parametrize(
    ("size", "unit", "scale"),
    [(2000.0, "Centimetres", "0.01"), (787.0, "Inches", "0.0254")],
)
def test_other_units_are_suspected_from_the_world(
    size: float, unit: str, scale: str, tmp_path: Path
) -> None:
    trimesh.creation.box((size, size, 1)).export(tmp_path / "hall.ply")
    world = World((mesh_obstacle("hall", "hall.ply", tmp_path),), bounds={"x": (0.0, 20.0)})
    assert f"{unit}? Then write scale = {scale}." in world.warnings[-1]
