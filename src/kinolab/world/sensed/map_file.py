"""Maps that somebody else drew: which cells are occupied, free or unknown.

Source: https://wiki.ros.org/map_server (the format, and the thresholds where a file says none);
Sturtevant, Benchmarks for grid-based pathfinding, IEEE
Transactions on Computational Intelligence and AI in Games 4(2), 2012 (the format of ``.map``).
"""

from __future__ import annotations

import io
import math
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.errors import InputError, printable
from kinolab.untrusted import BYTES, ELEMENTS, read
from kinolab.world.meshes.mesh import locate
from kinolab.world.meshes.mesh_reading import refusal

FORMATS = ("yaml", "yml", "map", "pgm", "png")
FREE, OCCUPIED, UNKNOWN = np.uint8(0), np.uint8(1), np.uint8(2)
OCCUPIED_FROM, FREE_BELOW = 0.65, 0.196  # map_saver's: its grey of unknown cells, 205, is between
MODES = ("trinary", "scale")
LIGHTEST = {"1": 1, "L": 255, "LA": 255, "RGB": 255, "RGBA": 255, "I;16": 65535, "I": 65535}


class OccupancyMap(NamedTuple):
    """Cells seen from above, the lowest row first.

    Attributes:
        cells: FREE, OCCUPIED or UNKNOWN, shape (ny, nx).
        resolution: Edge of a cell in [m].
        origin: x, y in [m] and yaw in [rad] of the lower left corner.
    """

    cells: NDArray[np.uint8]
    resolution: float
    origin: tuple[float, float, float]


def read_map(path: str | Path, *, root: Path, resolution: float | None = None) -> OccupancyMap:
    """Read a map: a description in YAML with its picture, a picture alone, or a ``.map`` file.

    Args:
        path: The file; a relative path is taken from ``root``.
        root: The folder of the scenario, which no file may leave.
        resolution: Edge of a cell in [m], of files that say none.

    Raises:
        InputError: If a file is missing, too large or none of these, or nothing, or two things,
            say how large a cell is.
    """
    where = str(path)
    content = read(locate(where, root, FORMATS, "map"), "map", where, "Crop the map.")
    kind = Path(where).suffix.lower()
    if kind in (".yaml", ".yml"):
        if resolution is not None:
            raise refusal(where, "says its resolution itself.", "Leave resolution out.")
        return _described(where, content, root)
    cells = _letters(where, content) if kind == ".map" else _of_light(lightness(where, content))
    return OccupancyMap(cells[::-1], required(where, resolution), (0.0, 0.0, 0.0))


def required(where: str, resolution: float | None) -> float:
    """Return the edge of a cell in [m].

    Raises:
        InputError: If there is none.
    """
    if resolution is None:
        what = "does not say how large its cells are."
        raise refusal(where, what, "Write resolution = 0.05 [m], the edge of a cell.")
    return resolution


def image_file(path: Path, content: bytes, root: Path) -> Path | None:
    """Return the picture that a description in YAML names, None where there is none.

    Args:
        path: Of the description, or of any other file, which names none.
        root: The folder that the picture must be in, or below.
    """
    if path.suffix.lower() not in (".yaml", ".yml"):
        return None
    try:
        named = _table(path.name, content)["image"]
        return locate(str(path.parent / str(named)), root, FORMATS[3:], "picture")
    except (InputError, KeyError):
        return None


def with_image(content: bytes, name: str) -> bytes:
    """Return a description that names another picture."""
    import yaml

    text: str = yaml.safe_dump(_table(name, content) | {"image": name}, sort_keys=False)
    return text.encode()


def _table(where: str, content: bytes) -> dict[str, Any]:
    import yaml  # late: few worlds have a map

    remedy = "It has lines such as image: map.pgm, resolution: 0.05 and origin: [0.0, 0.0, 0.0]."
    try:
        if len(content) > BYTES["yaml"]:
            raise ValueError(f"it is larger than {BYTES['yaml'] // 1000} kB")
        table = yaml.safe_load(content)
    except Exception as error:  # the parser raises whatever the bytes provoke
        cause = printable(str(error).splitlines()[0] if str(error) else type(error).__name__)
        raise refusal(where, f"is not readable YAML ({cause}).", remedy) from error
    if not isinstance(table, dict):
        raise refusal(where, "is not a map's description.", remedy)
    return table


def _described(where: str, content: bytes, root: Path) -> OccupancyMap:
    """Return the map of a description as map_server reads it."""
    table = _table(where, content)
    image, mode = table.get("image"), table.get("mode", MODES[0])
    if not isinstance(image, str):
        raise refusal(where, "names no picture.", "Write image: map.pgm.")
    if mode not in MODES:
        what = f"has the mode {printable(str(mode)[:40])}, which kinolab does not read."
        raise refusal(where, what, f"Save it with mode: {' or '.join(MODES)}.")
    size = _numbers(where, table, "resolution", 1, "0.05")[0]
    if size <= 0.0:
        raise refusal(where, "has no positive resolution.", "Write resolution: 0.05 [m].")
    x, y, yaw = _numbers(where, table, "origin", 3, "[0.0, 0.0, 0.0]")
    least, most = (
        _numbers(where, {key: default} | table, key, 1, str(default))[0]
        for key, default in (("free_thresh", FREE_BELOW), ("occupied_thresh", OCCUPIED_FROM))
    )
    if least > most:
        what = f"calls cells free below {least:g} and occupied above {most:g}."
        raise refusal(where, what, "Let free_thresh be below occupied_thresh.")
    negate = _numbers(where, {"negate": 0} | table, "negate", 1, "0")[0] != 0.0
    named = str(Path(where).parent / image)
    file = locate(named, root, FORMATS[3:], "picture")
    picture = read(file, "map", named, "Crop the map.")
    light, opaque = lightness(named, picture), None
    if mode == "scale" and light.shape[2] in (2, 4):
        light, opaque = light[:, :, :-1], light[:, :, -1] == 1.0
    cells = _of_light(1.0 - light if negate else light, least, most)
    if opaque is not None:
        cells[~opaque] = UNKNOWN
    return OccupancyMap(cells[::-1], size, (x, y, yaw))


def _numbers(
    where: str, table: dict[str, Any], key: str, count: int, example: str
) -> Sequence[float]:
    found = table.get(key)
    several = found if isinstance(found, list) else [found]
    numbers = [float(one) for one in several if isinstance(one, int | float)]
    if len(several) != count or len(numbers) != count or not all(map(math.isfinite, numbers)):
        what = f"has no {key}." if found is None else f"has a {key} that is no such number."
        if count > 1:
            meant = "where its lower left corner lies, in [m], and how it is turned, in [rad]"
            what = f"does not say by {key} {meant}."
        raise refusal(where, what, f"Write {key}: {example}.")
    return numbers


def lightness(where: str, content: bytes) -> NDArray[np.float32]:
    """Return a picture's channels, 0 black to 1 white, shape (rows, columns, channels).

    Raises:
        InputError: If it is no PNG, PGM or PPM, or too large.
    """
    from PIL import Image  # late, as above

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(io.BytesIO(content), formats=("PNG", "PPM")) as image:
                across, down = image.size
                if across * down > ELEMENTS["cells"]:
                    what = f"has {across} x {down} cells, more than {ELEMENTS['cells']}."
                    raise refusal(where, what, "Crop it, or join cells.")
                painted = "RGBA" if "transparency" in image.info else "RGB"
                plain = image.convert(painted) if image.mode in ("P", "PA") else image
                lightest, pixels = LIGHTEST[plain.mode], np.asarray(plain)
    except InputError:
        raise
    except Exception as error:  # Pillow's parsers raise whatever the bytes provoke
        what = "is not a readable picture of grey levels or colours."
        raise refusal(where, what, "Save it as PNG or PGM.") from error
    return np.asarray(pixels, np.float32).reshape(*pixels.shape[:2], -1) / np.float32(lightest)


def _of_light(
    light: NDArray[np.float32], least: float = FREE_BELOW, most: float = OCCUPIED_FROM
) -> NDArray[np.uint8]:
    """Return cells of which the dark ones are occupied; the mean of all channels counts."""
    taken = 1.0 - light.mean(axis=2, dtype=np.float64)
    cells = np.full(taken.shape, UNKNOWN)
    cells[taken > most] = OCCUPIED
    cells[taken < least] = FREE
    return cells


def _letters(where: str, content: bytes) -> NDArray[np.uint8]:
    """Return the cells of a Moving-AI map, one letter each."""
    head, begun, body = content.partition(b"map\n" if b"map\n" in content else b"map\r\n")
    words = head.split()
    known = dict(zip(words[::2], words[1::2], strict=False))
    rows = body.split()
    try:
        high, wide = int(known[b"height"]), int(known[b"width"])
    except (KeyError, ValueError):
        high = wide = 0
    if not begun or high < 1 or wide < 1:
        what = "is not a Moving-AI map."
        remedy = "It begins with the lines type octile, height 3, width 4 and map."
        raise refusal(where, what, remedy)
    if len(rows) != high or any(len(row) != wide for row in rows):
        lengths = sorted({*map(len, rows)})
        found = f"{lengths[0] if lengths else 0} to {lengths[-1] if lengths else 0}"
        what = f"says {high} rows of {wide} cells, and has {len(rows)} of {found}."
        raise refusal(where, what, "It may be cut short; fetch it again.")
    letters = np.frombuffer(b"".join(rows), np.uint8).reshape(high, wide)
    # ground and swamp; trees, water and what lies out of bounds are in the way
    return np.where(np.isin(letters, [*b".GS"]), FREE, OCCUPIED).astype(np.uint8)
