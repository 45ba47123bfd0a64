"""Small meshes as CAD programs write them: COLLADA with nodes within nodes, and OBJ."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from pathlib import Path

# The faces of a box as corners 4 x + 2 y + z, looking outward.
SIDES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))

Corner = Sequence[float]


def box_corners(low: Corner, high: Corner) -> list[tuple[float, float, float]]:
    """Return the eight corners of a box, numbered as in SIDES."""
    x, y, z = (tuple(pair) for pair in zip(low, high, strict=True))
    return list(product(x, y, z))


def obj(*boxes: tuple[Corner, Corner]) -> str:
    """Return boxes from one corner to the other as an OBJ of triangles."""
    lines = []
    for k, box in enumerate(boxes):
        lines += [f"v {x} {y} {z}" for x, y, z in box_corners(*box)]
        for a, b, c, d in SIDES:
            first = 8 * k + 1
            lines += [
                f"f {first + a} {first + b} {first + c}",
                f"f {first + a} {first + c} {first + d}",
            ]
    return "\n".join(lines) + "\n"


_SOURCE = """\
<source id="{id}"><float_array id="{id}-a" count="{count}">{numbers}</float_array>
<technique_common><accessor source="#{id}-a" count="{rows}" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
</accessor></technique_common></source>"""

_FRAME = """\
<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2026-01-01T00:00:00Z</created><modified>2026-01-01T00:00:00Z</modified>
{unit}{up}</asset>
<library_geometries>
{geometries}
</library_geometries>
{library}<library_visual_scenes><visual_scene id="scene">
{nodes}
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>
"""


def _source(name: str, rows: Sequence[Corner]) -> str:
    numbers = " ".join(str(number) for row in rows for number in row)
    return _SOURCE.format(id=name, count=3 * len(rows), rows=len(rows), numbers=numbers)


def geometry(name: str, low: Corner, high: Corner) -> str:
    """Return a box with a normal for each of its sides, as a geometry of COLLADA."""
    normals = [(-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1)]
    index = [
        f"{corner} {side}"
        for side, (a, b, c, d) in enumerate(SIDES)
        for corner in (a, b, c, a, c, d)
    ]
    return (
        f'<geometry id="{name}"><mesh>'
        + _source(f"{name}-p", box_corners(low, high))
        + _source(f"{name}-n", normals)
        + f'<vertices id="{name}-v"><input semantic="POSITION" source="#{name}-p"/></vertices>'
        + f'<triangles count="12"><input semantic="VERTEX" source="#{name}-v" offset="0"/>'
        + f'<input semantic="NORMAL" source="#{name}-n" offset="1"/><p>{" ".join(index)}</p>'
        + "</triangles></mesh></geometry>"
    )


def collada(
    geometries: Sequence[str], nodes: str, *, unit: str = "", up: str = "", library: str = ""
) -> str:
    """Return a COLLADA file.

    Args:
        geometries: What ``geometry`` returns.
        nodes: What stands in the scene, as XML.
        unit: In metres, as text; left out where it is empty.
        up: ``X_UP``, ``Y_UP`` or ``Z_UP``; left out where it is empty.
        library: Nodes that others stand for.
    """
    return _FRAME.format(
        unit=f'<unit name="inch" meter="{unit}"/>\n' if unit else "",
        up=f"<up_axis>{up}</up_axis>\n" if up else "",
        geometries="\n".join(geometries),
        nodes=nodes,
        library=f"<library_nodes>{library}</library_nodes>\n" if library else "",
    )


def nested(*, unit: str = "0.5", up: str = "Z_UP") -> str:
    """Return two boxes: one below two nodes that move, turn and scale it, one that stands twice."""
    nodes = """\
<node id="outer"><translate>10 0 0</translate><rotate>0 0 1 90</rotate>
<node id="inner"><scale>2 1 1</scale><translate>0 0 3</translate>
<instance_geometry url="#crate"/></node></node>
<node id="left"><matrix>1 0 0 -5 0 1 0 1 0 0 1 0 0 0 0 1</matrix>
<instance_node url="#post"/></node>
<node id="right"><instance_node url="#post"/></node>"""
    library = '<node id="post"><translate>0 0 7</translate><instance_geometry url="#rod"/></node>'
    boxes = [geometry("crate", (0, 0, 0), (1, 2, 3)), geometry("rod", (0, 0, -1), (1, 1, 4))]
    return collada(boxes, nodes, unit=unit, up=up, library=library)


def written(folder: Path, **files: str) -> Path:
    """Write files by their name, in which the last _ stands for the dot, and return the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / ".".join(name.rsplit("_", 1))).write_text(text, encoding="utf-8")
    return folder
