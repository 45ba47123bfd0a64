"""What is usable about a mesh, yet probably not meant: sides, holes, units, the axis that is up."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.world.meshes.mesh_cache import Mesh
from kinolab.world.meshes.mesh_components import Components
from kinolab.world.meshes.mesh_reading import AXES

MAX_EXTENT = 1000.0  # [m]; larger ones are most likely drawn in millimetres
FAR_TOO_LARGE = 500.0  # times as wide as the world, or as narrow: another unit was meant
UNITS = {"millimetres": 1e-3, "centimetres": 1e-2, "inches": 0.0254, "feet": 0.3048}  # [m]
ALIKE = 2.0  # factor within which two lengths fill the same world


def doubts(
    where: str,
    mesh: Mesh,
    vertices: Array,
    parts: Components,
    *,
    given: bool,
    scaled: bool,
    up: str,
) -> Iterator[str]:
    """Yield sentences about a placed mesh.

    Args:
        where: What its file is called.
        mesh: As it was read.
        vertices: At their place, in [m], shape (n, 3).
        given: Whether the scenario says what is solid.
        scaled: Whether it gives a scale.
        up: The axis of the file that it takes to point up.
    """
    copies, backs = mesh.repeated.tolist()
    if copies:
        yield f"{where}: has {_triangles(copies)} more than once; the copies are left out."
    if backs:
        share = "all of its triangles" if backs == len(mesh.faces) else _triangles(backs)
        sides = f"{where}: has {share} twice, facing both ways, as SketchUp writes them."
        solid = (
            "" if given else " Only their surface collides; solid = true fills what it encloses."
        )
        yield sides + solid
    single = np.ones(len(parts.volume), dtype=bool)
    single[parts.label[mesh.both]] = False
    if (parts.volume[single] == 0.0).any():
        yield f"{where}: is not watertight. Where it is open, only its surface collides."
    unit, axis = float(mesh.declared[0]), int(mesh.declared[1])
    if not scaled and unit > 0.0 and unit != 1.0:
        yield f"{where}: says that its unit is {unit:g} m. Then write scale = {unit:g}."
    elif (extent := np.ptp(vertices, axis=0).max()) > MAX_EXTENT:
        yield f"{where}: is {extent:.4g} m wide. Millimetres? Then write scale = 0.001."
    if axis >= 0 and AXES[axis] != up == "z":
        yield f'{where}: says that its {AXES[axis]} axis points up. Then write up = "{AXES[axis]}".'


def _triangles(count: int) -> str:
    return "1 triangle" if count == 1 else f"{count} triangles"


def likely_scale(extent: float, world: float) -> tuple[float, str] | None:
    """Return the scale that makes a mesh fit into its world, and the unit that this is, if known.

    Args:
        extent: The mesh's largest, in the file's units.
        world: The largest of ``[world] bounds``, in [m].
    """
    ratio = extent / world
    if ratio >= 30.0:  # the same, which may still be meant
        name = min(UNITS, key=lambda one: abs(math.log(ratio * UNITS[one])))
        return UNITS[name], name
    return (1000.0, "") if ratio <= 1.0 / FAR_TOO_LARGE else None


def misfits(name: str, extent: Array, bounds: Mapping[str, tuple[float, float]]) -> Iterator[str]:
    """Yield sentences about the extents (3,) of a placed mesh beside those of its world, in [m]."""
    wide = {axis: high - low for axis, (low, high) in bounds.items()}
    if not wide:
        return
    largest = float(extent.max())
    found = likely_scale(largest, max(wide.values()))
    if found is not None and largest > max(wide.values()):
        scale, unit = found
        times = largest / max(wide.values())
        yield (
            f"{name}: is {times:.3g} times as wide as [world] bounds. "
            f"{unit.capitalize()}? Then write scale = {scale:g}."
        )
    if "x" in wide and "y" in wide and _lies_on_its_side(extent, wide["x"], wide["y"]):
        size = " x ".join(f"{one:.3g}" for one in extent)
        world = f"{wide['x']:.3g} x {wide['y']:.3g} m"
        yield (
            f"{name}: is {size} m in a world of {world}, as if y pointed up in its file. "
            'Then write up = "y".'
        )


def _lies_on_its_side(extent: Array, x: float, y: float) -> bool:
    """Say whether a mesh would fill the world if its y axis pointed up, and does not as it is."""
    fills = 1.0 / ALIKE <= extent[0] / x <= ALIKE and 1.0 / ALIKE <= extent[2] / y <= ALIKE
    return bool(fills and extent[1] < min(y, extent[2]) / ALIKE)
