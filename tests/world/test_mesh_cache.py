"""Meshes on disk: read where they are there, read from their files where not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

from kinolab.errors import InputError
from kinolab.untrusted import ELEMENTS
from kinolab.world import load_mesh
from kinolab.world.meshes import mesh
from kinolab.world.meshes.mesh_cache import MESHES, Mesh


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("KINOLAB_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def parsed(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of the files that trimesh reads."""
    names: list[str] = []
    parse: Callable[..., Mesh] = mesh._sound_mesh

    def noted(where: str, content: bytes, materials: bytes, most: int) -> Mesh:
        names.append(where)
        return parse(where, content, materials, most)

    monkeypatch.setattr(mesh, "_sound_mesh", noted)
    return names


def two_balls(path: Path, apart: float) -> None:
    balls = [trimesh.creation.icosphere(subdivisions=1) for _ in range(2)]
    balls[1].apply_translation([apart, 0, 0])
    trimesh.util.concatenate(balls).export(path)


def same(one: Mesh, other: Mesh) -> bool:
    return all(map(np.array_equal, one, other))


def test_a_mesh_is_read_from_its_file_only_once(
    home: Path, tmp_path: Path, parsed: list[str]
) -> None:
    two_balls(tmp_path / "balls.stl", 3.0)
    read = load_mesh("balls.stl", root=tmp_path)
    kept = load_mesh("balls.stl", root=tmp_path)
    assert parsed == ["balls.stl"]
    assert same(read, kept)
    assert sorted(set(kept.label.tolist())) == [0, 1]
    assert all(part.flags.writeable and part.flags.aligned for part in kept)
    assert len(list(home.glob("*.mesh"))) == 1


def test_another_content_under_the_same_name_is_another_mesh(
    home: Path, tmp_path: Path, parsed: list[str]
) -> None:
    for apart in (3.0, 4.0):
        two_balls(tmp_path / "balls.stl", apart)
        width = np.ptp(load_mesh("balls.stl", root=tmp_path).vertices[:, 0])
        assert width == pytest.approx(apart + 2.0, abs=1e-6)  # [m]; STL has single precision
    assert len(parsed) == len(list(home.glob("*.mesh"))) == 2


@pytest.mark.parametrize("damage", [b"", MESHES.magic, MESHES.magic + bytes(100)])
def test_a_damaged_entry_is_made_anew(
    damage: bytes, home: Path, tmp_path: Path, parsed: list[str]
) -> None:
    two_balls(tmp_path / "balls.stl", 3.0)
    read = load_mesh("balls.stl", root=tmp_path)
    (entry,) = home.glob("*.mesh")
    entry.write_bytes(damage)
    assert same(load_mesh("balls.stl", root=tmp_path), read)
    assert parsed == ["balls.stl"] * 2


def test_a_mesh_that_was_kept_to_be_simplified_is_too_large_for_others(
    home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    two_balls(tmp_path / "balls.stl", 3.0)
    load_mesh("balls.stl", root=tmp_path, most=10**6)  # two balls of 80 triangles
    assert len(list(home.glob("*.mesh"))) == 1
    monkeypatch.setitem(ELEMENTS, "triangles", 159)
    with pytest.raises(InputError, match=r"has more than 159 triangles\. Write simplify = 159"):
        load_mesh("balls.stl", root=tmp_path)
