"""Distance grids on disk: read where they are there, built anew where damaged, never too many."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numba import typeof

from kinolab.files import keep_last_used
from kinolab.world import Obstacle, World, box_obstacle, sphere_obstacle
from kinolab.world.collision.collision_scene import collision_scene
from kinolab.world.distances import distance_field_cache
from kinolab.world.distances.distance_field import DistanceField, distance_field
from kinolab.world.distances.distance_field_cache import GRIDS, cached_distance_field

BOX = box_obstacle("box", (1.0, 1.0, 1.0), (2.0, 0.0, 0.5))
BALL = sphere_obstacle("ball", 0.7, (-2.0, 1.0, 0.0))


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder of entries, in which grids of this size are kept."""
    monkeypatch.setenv("KINOLAB_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(distance_field_cache, "MIN_CELLS", 1)
    return tmp_path / "cache"


@pytest.fixture
def builds(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many obstacles each grid has that is built while a test runs."""
    seen: list[int] = []

    def counted(obstacles: tuple[Obstacle, ...], finest: float) -> DistanceField:
        seen.append(len(obstacles))
        return distance_field(obstacles, finest)

    monkeypatch.setattr(distance_field_cache, "distance_field", counted)
    return seen


def same(one: DistanceField, other: DistanceField) -> bool:
    """Whether two grids are the same to the last bit, and to compiled code."""
    kinds = [(typeof(grid.low), typeof(grid.distance)) for grid in (one, other)]
    pairs = zip(one, other, strict=True)
    return kinds[0] == kinds[1] and all(np.array_equal(a, b) for a, b in pairs)


def test_a_grid_is_built_once(home: Path, builds: list[int]) -> None:
    grids = [cached_distance_field((BOX, BALL), 0.1) for _ in range(3)]
    assert builds == [2]
    assert all(same(grid, distance_field((BOX, BALL), 0.1)) for grid in grids)
    (entry,) = home.glob(f"*.{GRIDS.name}")
    assert entry.read_bytes().startswith(GRIDS.magic)
    assert {path.suffix for path in home.iterdir()} == {f".{GRIDS.name}"}  # and no half of one


@pytest.mark.usefixtures("home")
def test_what_is_read_may_be_written_to_and_nobody_else_sees_it() -> None:
    cached_distance_field((BOX,), 0.1)
    first = cached_distance_field((BOX,), 0.1)
    first.distance[:] = 7.0
    assert same(cached_distance_field((BOX,), 0.1), distance_field((BOX,), 0.1))


@pytest.mark.usefixtures("home")
def test_other_obstacles_or_another_resolution_are_another_entry(builds: list[int]) -> None:
    moved = box_obstacle("box", (1.0, 1.0, 1.0), (2.0, 0.0, 0.5 + 1e-15))
    worlds = [(BOX,), (BALL,), (BOX, BALL), (BALL, BOX), (moved,)]
    for obstacles in worlds:
        assert same(cached_distance_field(obstacles, 0.1), distance_field(obstacles, 0.1))
    assert same(cached_distance_field((BOX,), 0.11), distance_field((BOX,), 0.11))
    assert builds == [1, 1, 2, 2, 1, 1]


@pytest.mark.usefixtures("home")
def test_other_code_builds_another_entry(
    builds: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    cached_distance_field((BOX,), 0.1)
    monkeypatch.setattr("kinolab.store.code_in", lambda *_: "changed")
    cached_distance_field((BOX,), 0.1)
    assert builds == [1, 1]


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda _: b"",
    "truncated": lambda content: content[: len(content) // 2],
    "without its last byte": lambda content: content[:-1],
    "with one bit changed in a distance": lambda content: (
        content[:-9] + bytes([content[-9] ^ 1]) + content[-8:]
    ),
    "with another checksum": lambda content: (
        content[: len(GRIDS.magic)] + bytes(32) + content[len(GRIDS.magic) + 32 :]
    ),
    "only its beginning": lambda _: GRIDS.magic,
    "of another format": lambda content: content.replace(b"distances", b"distance ", 1),
    "text": lambda _: b"not a grid at all",
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_damaged_entry_is_built_anew(
    damage: Callable[[bytes], bytes], home: Path, builds: list[int]
) -> None:
    whole = cached_distance_field((BOX, BALL), 0.1)
    (entry,) = home.iterdir()
    sound = entry.read_bytes()
    entry.write_bytes(damage(sound))
    assert same(cached_distance_field((BOX, BALL), 0.1), whole)
    assert builds == [2, 2]
    assert entry.read_bytes() == sound  # mended


def test_a_folder_that_cannot_be_written_only_costs_time(
    home: Path, builds: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    home.parent.joinpath("file").write_text("no folder")
    monkeypatch.setenv("KINOLAB_CACHE", str(home.parent / "file" / "cache"))
    grids = [cached_distance_field((BOX,), 0.1) for _ in range(2)]
    assert builds == [1, 1]
    assert same(grids[0], grids[1])


def test_small_grids_and_empty_worlds_are_not_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("KINOLAB_CACHE", str(tmp_path / "cache"))
    assert cached_distance_field((BOX,), 0.5).distance.size < distance_field_cache.MIN_CELLS
    assert cached_distance_field(()).distance.size == 0
    assert not (tmp_path / "cache").exists()


def test_the_entries_that_were_not_used_for_longest_make_room(home: Path) -> None:
    worlds = [(BOX,), (BALL,), (BOX, BALL)]
    entries: list[Path] = []
    for age, obstacles in enumerate(worlds):
        cached_distance_field(obstacles, 0.1)
        (entry,) = set(home.iterdir()) - set(entries)
        os.utime(entry, (1000 + age, 1000 + age))
        entries.append(entry)
    other = home / "of_another_kind.machine"
    other.write_bytes(bytes(10_000))
    cached_distance_field((BOX,), 0.1)  # used: the oldest is another one now
    all_in_all = sum(entry.stat().st_size for entry in entries)
    keep_last_used(entries[2], all_in_all - 1)
    assert set(home.iterdir()) == {entries[0], entries[2], other}


def test_what_was_just_built_stays_however_little_room_there_is(
    home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(distance_field_cache, "GRIDS", replace(GRIDS, most=1))
    for obstacles in [(BOX,), (BALL,)]:
        cached_distance_field(obstacles, 0.1)
        (entry,) = home.iterdir()
    assert same(cached_distance_field((BALL,), 0.1), distance_field((BALL,), 0.1))
    assert entry.is_file()


def test_machines_move_among_obstacles_whose_grid_was_read(home: Path, builds: list[int]) -> None:
    """The same bounds, whether the grid was built or comes from disk."""
    distances = []
    for k in range(2):
        world = World((BOX, box_obstacle("other", (1.0 + k, 1.0, 1.0), (9.0, 0.0, 0.0))))
        distances += [collision_scene((), world).distance]
        distances += [cached_distance_field(world.obstacles)]
    assert builds == [2, 2]
    assert same(distances[0], distances[1])
    assert same(distances[2], distances[3])
    assert len(list(home.iterdir())) == 2
