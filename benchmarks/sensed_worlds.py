"""How long maps and clouds take to be loaded, and whether free and occupied are right.

Maps of twenty kinds are drawn: rooms, mazes and noise, 300 to 2000 cells wide, in every format.
Each is asked at 10 000 random points, and compared with its picture. Files are written to a folder
that is removed. Run: ``python benchmarks/sensed_worlds.py``.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from kinolab.numerics.struct import Record
from kinolab.world.distances.distance_field import distance_field
from kinolab.world.distances.triangle_grid import inside, mesh_grid
from kinolab.world.distances.triangle_tree import mesh_tree
from kinolab.world.sensed.map_obstacles import map_obstacles
from kinolab.world.sensed.point_cloud import cloud_obstacle

RESOLUTION = 0.05  # [m]
POINTS = 10_000
Picture = NDArray[np.uint8]


def drawn(kind: str, size: int, seed: int) -> Picture:
    """Draw 0 occupied, 205 unknown and 254 free, as map_saver does."""
    random = np.random.default_rng(seed)
    picture = np.full((size, size), 254, np.uint8)
    if kind == "noise":
        picture[random.random(picture.shape) < 0.02] = 0
    elif kind == "maze":
        cell = size // 30
        walls = np.kron(random.random((30, 30)) < 0.35, np.ones((cell, cell), bool))
        picture[: walls.shape[0], : walls.shape[1]][walls] = 0
    else:
        picture[: size // 8], picture[:, -size // 9 :] = 205, 205
        for at in range(size // 8, size, size // 10):
            picture[at : at + 3], picture[:, at : at + 3] = 0, 0
            doors = random.integers(0, size - 40, 12)
            for door in doors:
                picture[at : at + 3, door : door + 40] = 254
                picture[door : door + 40, at : at + 3] = 254
        i, j = random.integers(0, size, (2, size * size // 2000))
        picture[i, j] = random.choice([0, 205], len(i))
    return picture


def written(folder: Path, picture: Picture, form: str) -> tuple[str, float | None]:
    """Write a map; return its file and the resolution that it does not say."""
    image = Image.fromarray(picture)
    if form == "map":
        rows = "\n".join("".join(row) for row in np.where(picture == 254, ".", "@").tolist())
        head = f"type octile\nheight {picture.shape[0]}\nwidth {picture.shape[1]}\nmap\n"
        (folder / "a.map").write_text(f"{head}{rows}\n")
        return "a.map", RESOLUTION
    if form == "picture":
        image.save(folder / "a.png")
        return "a.png", RESOLUTION
    name = "a.pgm" if form == "trinary" else "a.png"
    image.save(folder / name)
    text = f"image: {name}\nmode: {form}\nresolution: {RESOLUTION}\norigin: [0.0, 0.0, 0.0]\n"
    (folder / "a.yaml").write_text(f"{text}occupied_thresh: 0.65\nfree_thresh: 0.196\n")
    return "a.yaml", None


def maps() -> Iterator[tuple[str, str, int]]:
    """Yield twenty kinds: what is drawn, the format, and the cells of a side."""
    kinds = product(("rooms", "maze", "noise"), ("trinary", "scale", "picture", "map"))
    sizes = (300, 1000)
    for k, (kind, form) in enumerate(kinds):
        yield kind, form, sizes[k % 2]
    for kind, form in product(("rooms", "maze"), ("trinary", "scale", "picture", "map")):
        yield kind, form, 2000


def main() -> None:
    """Print a line per map and one per cloud."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for seed, (kind, form, size) in enumerate(maps()):
            picture = drawn(kind, size, seed)
            file, resolution = written(folder, picture, form)
            begun = time.perf_counter()
            walls = map_obstacles("map", file, folder, resolution=resolution)
            loaded = time.perf_counter() - begun
            grids = [mesh_grid([wall]) for wall in walls]
            mesh_tree(walls)
            indexed = time.perf_counter() - begun
            cells = np.random.default_rng(seed).random((POINTS, 2)) * size
            taken = picture[size - 1 - cells[:, 1].astype(int), cells[:, 0].astype(int)] < 254
            points = np.column_stack([cells * RESOLUTION, np.full(POINTS, 0.5)])
            records = [Record(grid) for grid in grids]
            found = [any(inside(point, 0, one) for one in records) for point in points]
            boxes = sum(len(wall.faces) for wall in walls) // 12
            wrong = np.count_nonzero(np.array(found) != taken)
            print(
                f"{kind:6} {form:8} {size:5}: {boxes:7} boxes, loaded in {loaded:.2f} s, "
                f"indexed in {indexed:.2f} s, {wrong} of {POINTS} points wrong",
                flush=True,
            )
        cloud(folder)


def cloud(folder: Path) -> None:
    """Load a million points, and merge them."""
    points = np.random.default_rng(0).uniform([0, 0, 0.1], [50, 50, 3], (1_000_000, 3))
    names = "".join(f"property float {axis}\n" for axis in "xyz")
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n{names}end_header\n"
    )
    (folder / "a.ply").write_bytes(head.encode() + points.astype("<f4").tobytes())
    for voxel in (None, 0.2):
        begun = time.perf_counter()
        balls = cloud_obstacle("cloud", "a.ply", folder, radius=0.03, voxel=voxel)
        loaded = time.perf_counter() - begun
        mesh_tree([balls])
        distance_field([balls], 0.05)
        ready = time.perf_counter() - begun
        print(f"{balls}: loaded in {loaded:.2f} s, indexed in {ready:.2f} s", flush=True)


if __name__ == "__main__":
    main()
