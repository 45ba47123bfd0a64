"""Write the meshes of the built-in scenarios; run it after changing a world.

python tools/meshes/write_meshes.py [--check]

With --check nothing is written: it says which files are not what their scripts draw.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

HERE = Path(__file__).resolve().parent
FOLDER = HERE.parents[1] / "scenarios" / "meshes"
if str(HERE) not in sys.path:  # the scripts of this folder are no package
    sys.path.insert(0, str(HERE))

import bracket  # noqa: E402
import canyon  # noqa: E402
import cave  # noqa: E402
import dock  # noqa: E402
import factory  # noqa: E402
import maze  # noqa: E402
import park  # noqa: E402
import parking  # noqa: E402
import slalom  # noqa: E402
import truss  # noqa: E402
import warehouse  # noqa: E402
from maze import DISK_MAZE, THICKNESS  # noqa: E402
from solids import Solid  # noqa: E402

__all__ = ["DISK_MAZE", "MESHES", "THICKNESS", "drawn", "main"]

WORLDS = (bracket, canyon, cave, dock, factory, maze, park, parking, slalom, truss, warehouse)
MESHES: dict[str, Callable[[], Solid]] = {
    name: draw for world in WORLDS for name, draw in world.MESHES.items()
}


def drawn(name: str) -> tuple[int, bytes]:
    """Return how many triangles a mesh has, and the bytes of its file."""
    solid = MESHES[name]()
    return len(solid.faces), solid.encoded(Path(name).suffix)


def main() -> int:
    """Write or check every mesh of the built-in scenarios; return 1 if one is not current."""
    parser = argparse.ArgumentParser(description="Write the meshes of the built-in scenarios.")
    parser.add_argument("--check", action="store_true", help="write nothing, only compare")
    check = parser.parse_args().check
    current = [_checked(name) if check else _written(name) for name in sorted(MESHES)]
    return 0 if all(current) else 1


def _written(name: str) -> bool:
    triangles, content = drawn(name)
    (FOLDER / name).write_bytes(content)
    print(f"{name}: {triangles} triangles, {len(content)} bytes")
    return True


def _checked(name: str) -> bool:
    file = FOLDER / name
    current = file.is_file() and file.read_bytes() == drawn(name)[1]
    print(f"{name}: {'current' if current else 'NOT what its script draws'}")
    return current


if __name__ == "__main__":
    sys.exit(main())
