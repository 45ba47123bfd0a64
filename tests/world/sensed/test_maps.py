"""Maps as obstacles: what is free and what is occupied, and what is said of files that are none."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from PIL import Image

from kinolab.errors import EndpointError, InputError
from kinolab.loading import load
from kinolab.numerics.struct import Record
from kinolab.runs.assets import assets_of, portable_scenario
from kinolab.world import Obstacle
from kinolab.world.distances.triangle_grid import inside, mesh_grid
from kinolab.world.sensed.cell_rectangles import rectangles
from kinolab.world.sensed.map_file import FREE, OCCUPIED, UNKNOWN, read_map
from kinolab.world.sensed.map_obstacles import map_obstacles, relief_obstacle

YAML = """\
image: map.pgm
resolution: 0.5
origin: [1.0, -2.0, 0.3]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""


def office(folder: Path, seed: int = 0, shape: tuple[int, int] = (20, 30)) -> NDArray[np.uint8]:
    """Write a map of random cells; return its picture."""
    levels = np.array([0, 205, 254], np.uint8)
    picture = np.random.default_rng(seed).choice(levels, shape, p=[0.3, 0.2, 0.5])
    Image.fromarray(picture).save(folder / "map.pgm")
    (folder / "map.yaml").write_text(YAML)
    return picture


def filled(points: NDArray[np.float64], *obstacles: Obstacle) -> NDArray[np.bool_]:
    grids = [Record(mesh_grid([obstacle])) for obstacle in obstacles]
    return np.array([any(inside(point, 0, grid) for grid in grids) for point in points])


@pytest.mark.parametrize("seed", range(5))
def test_rectangles_cover_the_marked_cells_and_no_other_once(seed: int) -> None:
    marked = np.random.default_rng(seed).random((23, 17)) < 0.2 * (seed + 1)
    count = np.zeros(marked.shape, int)
    for top, left, bottom, right in rectangles(marked):
        count[top:bottom, left:right] += 1
    assert (count == marked).all()


def test_a_block_of_cells_is_one_rectangle() -> None:
    marked = np.zeros((9, 7), bool)
    marked[2:5, 1:6] = True
    assert rectangles(marked).tolist() == [[2, 1, 5, 6]]
    assert rectangles(np.zeros((3, 3), bool)).shape == (0, 4)


def test_walls_stand_where_the_picture_is_dark_seen_from_the_origin(tmp_path: Path) -> None:
    """The origin is the lower left corner, about which the yaw turns the map."""
    picture = office(tmp_path)
    random = np.random.default_rng(1)
    local = random.random((10_000, 2)) * np.array([30, 20]) * 0.5
    cos, sin = np.cos(0.3), np.sin(0.3)
    points = np.column_stack(
        [
            1.0 + cos * local[:, 0] - sin * local[:, 1],
            -2.0 + sin * local[:, 0] + cos * local[:, 1],
            random.uniform(0.01, 0.69, len(local)),
        ]
    )
    column, row = (local / 0.5).astype(int).T
    level = picture[19 - row, column]
    known, unknown = map_obstacles("m", "map.yaml", tmp_path, height=0.7)
    assert (filled(points, known) == (level == 0)).all()
    assert (filled(points, known, unknown) == (level < 254)).all()
    above = points + np.array([0.0, 0.0, 0.7])
    assert not filled(above, known, unknown).any()


def test_walls_have_the_volume_of_their_cells(tmp_path: Path) -> None:
    picture = office(tmp_path)
    (known,) = map_obstacles("m", "map.yaml", tmp_path, height=2.0, unknown="free")
    solid = trimesh.Trimesh(known.vertices, known.faces, process=False)
    expected = (picture == 0).sum() * 0.5**2 * 2.0  # [m^3]
    assert np.isclose(solid.volume, expected, rtol=1e-12)
    assert known.parts is not None
    assert np.isclose(known.parts.volume.sum(), expected, rtol=1e-12)
    assert known.bounding_box()[0][2] == 0.0


def test_a_picture_alone_is_read_as_the_same_map(tmp_path: Path) -> None:
    picture = office(tmp_path)
    Image.fromarray(picture).save(tmp_path / "map.png")
    one = read_map("map.png", root=tmp_path, resolution=0.5)
    assert (one.cells == read_map("map.yaml", root=tmp_path).cells).all()
    assert one.resolution == 0.5


def test_negated_maps_swap_dark_and_light(tmp_path: Path) -> None:
    Image.fromarray(np.array([[0, 255]], np.uint8)).save(tmp_path / "map.pgm")
    (tmp_path / "map.yaml").write_text(YAML)
    assert read_map("map.yaml", root=tmp_path).cells.tolist() == [[OCCUPIED, FREE]]
    (tmp_path / "map.yaml").write_text(YAML.replace("negate: 0", "negate: 1"))
    assert read_map("map.yaml", root=tmp_path).cells.tolist() == [[FREE, OCCUPIED]]


def test_what_is_transparent_is_unknown_in_mode_scale(tmp_path: Path) -> None:
    """In trinary mode, map_server counts opacity as one more channel of light."""
    pixels = np.array([[[0, 255], [254, 255], [0, 0]]], np.uint8)
    Image.fromarray(pixels, "LA").save(tmp_path / "map.png")
    text = YAML.replace("map.pgm", "map.png")
    (tmp_path / "map.yaml").write_text(text + "mode: scale\n")
    assert read_map("map.yaml", root=tmp_path).cells.tolist() == [[OCCUPIED, FREE, UNKNOWN]]
    (tmp_path / "map.yaml").write_text(text)
    assert read_map("map.yaml", root=tmp_path).cells.tolist() == [[UNKNOWN, FREE, OCCUPIED]]


@pytest.mark.parametrize("mode", ["1", "L", "P", "RGB", "RGBA", "I;16"])
def test_pictures_of_every_kind_say_the_same(mode: str, tmp_path: Path) -> None:
    levels = np.array([[0, 255], [255, 0]], np.uint8)
    image = Image.fromarray(levels)
    if mode == "I;16":
        image = Image.fromarray(levels.astype(np.uint16) * 257)
    image = image if image.mode == mode else image.convert(mode)
    if mode == "RGBA":  # opacity counts as light
        image.putalpha(Image.fromarray(levels))
    image.save(tmp_path / "map.png")
    cells = read_map("map.png", root=tmp_path, resolution=1.0).cells
    assert cells.tolist() == [[FREE, OCCUPIED], [OCCUPIED, FREE]]


def test_moving_ai_maps_have_their_first_row_on_top(tmp_path: Path) -> None:
    (tmp_path / "a.map").write_text("type octile\nheight 2\nwidth 3\nmap\n@.T\nGSW\n")
    cells = read_map("a.map", root=tmp_path, resolution=1.0).cells
    assert cells.tolist() == [[FREE, FREE, OCCUPIED], [OCCUPIED, FREE, OCCUPIED]]


def test_heights_are_a_closed_block_through_the_middles_of_pixels(tmp_path: Path) -> None:
    levels = np.random.default_rng(0).integers(0, 65535, (7, 9)).astype(np.uint16)
    Image.fromarray(levels).save(tmp_path / "hills.png")
    block = relief_obstacle("hills", "hills.png", tmp_path, relief=2.0, resolution=0.5)
    solid = trimesh.Trimesh(block.vertices, block.faces)
    assert solid.is_watertight
    assert solid.is_winding_consistent
    assert block.parts is not None
    assert np.isclose(solid.volume, block.parts.volume.sum())
    heights = 2.0 * levels[::-1] / 65535.0
    j, i = np.meshgrid(range(9), range(7))
    expected = np.column_stack([0.5 * j.ravel(), 0.5 * i.ravel(), heights.ravel()])
    assert np.allclose(block.vertices[:63], expected, atol=1e-6)  # [m]; pictures are float32


@pytest.mark.parametrize(("limit", "steep"), [(0.4, True), (0.5, False)])
def test_ground_is_a_wall_where_it_is_steeper_than_the_limit(
    limit: float, steep: bool, tmp_path: Path
) -> None:
    """A ramp of a known slope, atan(0.5) = 0.464 rad, between two level fields."""
    levels = np.clip(np.arange(30) - 10, 0, 10) * 6553  # 6553.5 would be a tenth of white
    Image.fromarray(np.tile(levels.astype(np.uint16), (5, 1))).save(tmp_path / "ramp.png")
    given = {"relief": 5.0, "resolution": 1.0, "max_slope": limit}
    if not steep:
        with pytest.raises(InputError, match=r"nowhere steeper than 0\.5 rad"):
            relief_obstacle("ramp", "ramp.png", tmp_path, **given)
        return
    wall = relief_obstacle("ramp", "ramp.png", tmp_path, **given)
    low, high = wall.bounding_box()
    assert np.allclose([low, high], [[10.0, 0.0, 0.0], [20.0, 4.0, 1.0]])  # [m]
    assert "in the plane" in str(wall)


def test_a_start_on_an_unknown_cell_says_so_with_a_remedy(tmp_path: Path) -> None:
    Image.fromarray(np.array([[205, 254, 0]], np.uint8)).save(tmp_path / "map.pgm")
    (tmp_path / "map.yaml").write_text(YAML.replace("1.0, -2.0, 0.3", "-0.25, -0.25, 0"))
    problem = load(written(tmp_path))
    with pytest.raises(EndpointError, match=r'map unknown\..*or write unknown = "free"'):
        problem.check_endpoints()
    free = load(written(tmp_path, world='map = "map.yaml"\nunknown = "free"'))
    assert [obstacle.name for obstacle in free.world.obstacles] == ["map"]


def written(folder: Path, more: str = "", world: str = 'map = "map.yaml"') -> Path:
    path = folder / "coin.toml"
    path.write_text(
        'schema = 1\ntitle = "A coin on a map"\n[system]\nname = "rolling_disk"\n'
        f'[world]\nbounds = {{ x = [-9, 9], y = [-9, 9] }}\nground = "plane"\n'
        f"[[world.obstacle]]\n{world}\n{more}[goal]\nx = 5.0\n"
    )
    return path


def test_a_run_has_the_map_and_its_picture_with_it(tmp_path: Path) -> None:
    office(tmp_path)
    problem = load(written(tmp_path))
    files = assets_of(problem)
    assert files["1_map.pgm"] == (tmp_path / "map.pgm").read_bytes()
    assert b"image: 1_map.pgm" in files["1_map.yaml"]
    home = tmp_path / "run" / "assets"
    home.mkdir(parents=True)
    for name, content in files.items():
        (home / name).write_bytes(content)
    entry = portable_scenario(problem).world.obstacle[0]
    assert entry.map == "assets/1_map.yaml"
    again = map_obstacles("map", str(entry.map), home.parent)
    for one, other in zip(again, problem.world.obstacles, strict=True):
        assert (one.vertices == other.vertices).all()


BAD = {
    'map = "map.png"': "map.png: does not say how large its cells are. Write resolution",
    'map = "map.yaml"\nresolution = 1.0': "says its resolution itself. Leave resolution out.",
    'map = "cut.map"\nresolution = 1.0': "says 2 rows of 2 cells, and has 1 of 2 to 2.",
    'map = "no.map"\nresolution = 1.0': "is not a Moving-AI map.",
    'map = "gone.yaml"': "does not exist. Map files are looked up from",
    'map = "text.png"\nresolution = 1.0': "is not a readable picture of grey levels or colours.",
    'map = "free.png"\nresolution = 1.0': "has no occupied cell.",
    'map = "where.yaml"': "does not say by origin where its lower left corner lies",
    'map = "raw.yaml"': "has the mode raw, which kinolab does not read.",
    'map = "out.yaml"': "lies outside",
    'map = "list.yaml"': "is not a map's description.",
    'map = "photo.jpg"': '"photo.jpg" is not a map format that kinolab reads',
    'map = "map.png"\nresolution = 1.0\nmax_slope = 0.3': "nothing says how high white is.",
    'map = "map.png"\nresolution = 1.0\nsolid = true': "solid is a key of meshes only.",
    "box = [1, 1, 1]\nheight = 2.0": "height is a key of maps only.",
    'map = "map.yaml"\nmotion = { velocity = [1.0, 0.0, 0.0] }': "maps do not move.",
}


@pytest.mark.parametrize("given", BAD)
def test_what_is_wrong_with_a_map_is_said(given: str, tmp_path: Path) -> None:
    picture = office(tmp_path)
    Image.fromarray(picture).save(tmp_path / "map.png")
    Image.fromarray(np.full_like(picture, 255)).save(tmp_path / "free.png")
    files = {
        "cut.map": "type octile\nheight 2\nwidth 2\nmap\n..\n",
        "no.map": "hello",
        "text.png": "hello",
        "where.yaml": YAML.replace("origin", "orign"),
        "raw.yaml": YAML + "mode: raw\n",
        "out.yaml": YAML.replace("map.pgm", "../map.pgm"),
        "list.yaml": "- 1\n",
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=re.escape(BAD[given])):
        load(written(tmp_path, world=given))
