"""What is in a mesh file, by trimesh: triangles, their colours, and what it says of itself."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.world.meshes.mesh_limits import require_size
from kinolab.world.meshes.obj_materials import Materials
from kinolab.world.shapes.shape_surfaces import Faces

if TYPE_CHECKING:
    import trimesh

AXES = "xyz"
UNPAINTED = np.array([184, 192, 208], dtype=np.uint8)  # of parts without a colour beside others


class RawMesh(NamedTuple):
    """Triangles as a file gives them, nothing merged or checked.

    Attributes:
        vertices: Shape (n, 3), in the file's units.
        faces: Shape (m, 3).
        colors: Red, green, blue of each face, shape (m, 3); (0, 3) where the file has none.
        unit: What the file says that its unit is, in [m]; 0 where it says nothing.
        up: The axis that the file says points up, 0 to 2; -1 where it says nothing.
    """

    vertices: Array
    faces: Faces
    colors: NDArray[np.uint8]
    unit: float
    up: int


def refusal(where: str, what: str, remedy: str = "") -> InputError:
    """Make the error for one mistake in one file."""
    return InputError([Mistake(where, what, remedy)])


def too_many(where: str, most: int) -> InputError:
    """Make the error for a file of more than so many triangles."""
    remedy = f"Write simplify = {min(most, 200_000)} to have it simplified with a proved error."
    return refusal(where, f"has more than {most} triangles.", remedy)


def read_triangles(where: str, kind: str, content: bytes, materials: bytes, most: int) -> RawMesh:
    """Let trimesh read the bytes; without a file name it has no folder to load more from.

    Args:
        where: What the file is called in messages.
        kind: Its format, in small letters.
        materials: Content of the file of materials that an OBJ names; empty without one.
        most: Triangles that are read.

    Raises:
        InputError: If it is no mesh, or too large.
    """
    import trimesh  # late: a mesh that is in the cache needs none

    if kind == "dae":
        _require_collada(where)
    try:
        require_size(where, kind, content)
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            scene = trimesh.load_scene(
                io.BytesIO(content), file_type=kind, process=False, resolver=Materials(materials)
            )
            vertices, faces, colors = _flatten(where, scene, most)
    except InputError:
        raise
    except Exception as error:  # trimesh's parsers raise whatever the bytes provoke
        cause = f" ({type(error).__name__}: {error})".splitlines()[0]
        if isinstance(error, ImportError):  # it takes the bytes for text, and has a guess to make
            cause = ""
        remedy = "It may be cut short; export it again."
        raise refusal(where, f"is not a readable {kind.upper()} file{cause}.", remedy) from error
    return RawMesh(vertices, faces, colors, *_said(kind, content))


def _require_collada(where: str) -> None:
    try:
        import collada  # noqa: F401  # what trimesh reads DAE files with
    except ImportError as error:
        remedy = "Install it by pip install 'kinolab[collada]', or convert the file to GLB."
        raise refusal(where, "DAE files are read by pycollada, which is absent.", remedy) from error


def _flatten(where: str, scene: trimesh.Scene, most: int) -> tuple[Array, Faces, NDArray[np.uint8]]:
    """Join the parts of a scene in its frame, counting first: instances multiply cheaply."""
    import trimesh  # late, as above

    placed = [scene.graph[node] for node in scene.graph.nodes_geometry]
    parts = [(pose, scene.geometry[name]) for pose, name in placed]
    parts = [(pose, part) for pose, part in parts if isinstance(part, trimesh.Trimesh)]
    count = sum(len(part.faces) for _, part in parts)
    if count > most:
        raise too_many(where, most)
    if not count:
        raise refusal(where, "has no faces.", "Export triangles, not points or curves.")
    offsets = np.cumsum([0, *(len(part.vertices) for _, part in parts)])
    vertices = [np.asarray(part.vertices) @ pose[:3, :3].T + pose[:3, 3] for pose, part in parts]
    faces = [_sound(where, part) + first for (_, part), first in zip(parts, offsets, strict=False)]
    colors = _colors([part for _, part in parts])
    return np.concatenate(vertices).astype(np.float64), np.concatenate(faces), colors


def _sound(where: str, part: trimesh.Trimesh) -> Faces:
    faces = np.asarray(part.faces, dtype=np.int64)
    if faces.size and (faces.min() < 0 or faces.max() >= len(part.vertices)):
        raise refusal(where, "has a face with a vertex that does not exist.", "Export it again.")
    return faces


def _colors(parts: Sequence[trimesh.Trimesh]) -> NDArray[np.uint8]:
    """Return the colours (m, 3) of the faces of all parts; (0, 3) where no part has one.

    They are reduced to few: a scan has as many as triangles, which no page draws at once.
    """
    found = [_own_colors(part) for part in parts]
    if all(own is None for own in found):
        return np.zeros((0, 3), np.uint8)
    counts = [len(part.faces) for part in parts]
    each = [UNPAINTED if own is None else own for own in found]
    rgb = np.concatenate(
        [np.broadcast_to(own, (count, 3)) for own, count in zip(each, counts, strict=True)]
    )
    if len(np.unique(rgb, axis=0)) <= 32:
        return rgb
    from PIL import Image  # late: few files have so many

    few = Image.fromarray(np.ascontiguousarray(rgb[None])).quantize(32)
    return np.array(few.convert("RGB"), dtype=np.uint8).reshape(-1, 3)


def _own_colors(part: trimesh.Trimesh) -> NDArray[np.uint8] | None:
    """Return the colours of a part's faces, or of its material; textures are not looked at."""
    visual = part.visual
    if visual.kind in {"face", "vertex"}:
        return np.asarray(visual.face_colors, dtype=np.uint8)[:, :3]
    material = getattr(visual, "material", None)
    color = getattr(material, "baseColorFactor", None)
    if color is None:
        color = getattr(material, "diffuse", None)
        written = "kd" in getattr(material, "kwargs", {})  # in an OBJ's materials
        # of materials that have no colour of their own, in trimesh
        if color is not None and (np.asarray(color)[:3] == 102).all() and not written:
            return None
    if color is None:
        return None
    rgb = np.asarray(color)[:3]
    if rgb.dtype.kind == "f":
        rgb = 255.0 * np.clip(rgb, 0.0, 1.0)
    return np.broadcast_to(rgb.astype(np.uint8), (len(part.faces), 3))


def _said(kind: str, content: bytes) -> tuple[float, int]:
    """Return the unit in [m] and the axis that points up, as a file says it; 0 and -1 if not."""
    if kind != "dae":
        return 0.0, -1
    head = content[:100_000]
    axis = re.search(rb"<up_axis>\s*([XYZ])_UP\s*</up_axis>", head)
    unit = re.search(rb"<unit\b[^>]*\bmeter\s*=\s*[\"']([0-9.eE+-]+)[\"']", head)
    try:
        metres = float(unit[1]) if unit else 0.0
    except ValueError:
        metres = 0.0
    return metres, AXES.index(axis[1].decode().lower()) if axis else -1
