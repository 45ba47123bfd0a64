"""Mesh files that somebody else wrote: read with suspicion, refused with an explanation."""

from __future__ import annotations

import io
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.world.shape_surfaces import Faces

if TYPE_CHECKING:
    import trimesh
from kinolab.world.mesh_cache import Mesh, entry_for, keep_mesh, read_mesh
from kinolab.world.mesh_components import Components, connected_parts

FORMATS = ("stl", "obj", "ply", "glb", "off")
MAX_BYTES = 200_000_000
MAX_TRIANGLES = 2_000_000
MAX_COORDINATE = 1e9  # [m]
MAX_EXTENT = 1000.0  # [m]; larger ones are most likely drawn in millimetres


def load_mesh(path: str | Path, *, root: Path) -> Mesh:
    """Read an STL, OBJ, PLY, GLB or OFF file from ``root`` or a folder below it.

    Nothing but the file itself is read: materials, textures and remote buffers are not followed.

    Args:
        path: The file; a relative path is taken from ``root``.
        root: The folder of the scenario, which meshes may not leave, not even by a link.

    Raises:
        InputError: If the file is missing, too large, of another format, or not a sound mesh.
    """
    where = str(path)
    content = _read(where, _locate(where, root))
    kept = entry_for(_format(where), content)
    mesh = read_mesh(kept)
    if mesh is None:
        mesh = _sound_mesh(where, content)
        keep_mesh(kept, mesh)
    return mesh


def _sound_mesh(where: str, content: bytes) -> Mesh:
    vertices, faces = _parse(where, content)
    check(where, vertices, faces)
    vertices, faces = merge_duplicates(vertices, faces)
    if not len(faces):
        raise refusal(where, "has no triangle with three different corners.")
    return Mesh(vertices, faces, connected_parts(len(vertices), faces))


def _format(where: str) -> str:
    return Path(where).suffix.lower().removeprefix(".")


def refusal(where: str, what: str, remedy: str = "") -> InputError:
    """Make the error for one mistake in one file."""
    return InputError([Mistake(where, what, remedy)])


def merge_duplicates(vertices: Array, faces: Faces) -> tuple[Array, Faces]:
    """Merge vertices (n, 3) at the same place; drop faces (m, 3) that this leaves without area.

    Vertices that no face uses go as well: they would widen every bounding box.
    """
    used, faces = np.unique(faces, return_inverse=True)
    vertices = vertices[used] + 0.0  # -0.0 becomes 0.0
    distinct, index = np.unique(vertices, axis=0, return_inverse=True)
    merged = index.reshape(-1)[faces.reshape(-1, 3)].astype(np.int64)
    a, b, c = merged.T
    return distinct, merged[(a != b) & (b != c) & (c != a)]


def _locate(where: str, root: Path) -> Path:
    if _format(where) not in FORMATS:
        known = ", ".join(name.upper() for name in FORMATS)
        raise refusal(where, "is not a mesh format that kinolab reads.", f"Convert it to {known}.")
    try:
        home = root.resolve()
        file = (home / where).resolve()
        inside, exists = file.is_relative_to(home), file.is_file()
    except (OSError, ValueError, RuntimeError) as error:
        raise refusal(where, f"cannot be found ({error}).") from error
    if not inside:
        raise refusal(where, f"lies outside {home}.", "Copy the mesh beside its scenario.")
    if not exists:
        raise refusal(where, "does not exist.", f"Meshes are looked up from {home}.")
    return file


def _read(where: str, file: Path) -> bytes:
    try:
        with file.open("rb") as stream:
            content = stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise refusal(where, f"cannot be read ({error.strerror}).") from error
    if len(content) > MAX_BYTES:
        raise refusal(where, f"is larger than {MAX_BYTES // 10**6} MB.", "Simplify the mesh.")
    return content


def _parse(where: str, content: bytes) -> tuple[Array, Faces]:
    """Let trimesh read the bytes; without a file name it has no folder to load more from."""
    import trimesh  # late: a mesh that is in the cache needs none

    kind = _format(where)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            scene = trimesh.load_scene(io.BytesIO(content), file_type=kind, process=False)
            return _flatten(where, scene)
    except InputError:
        raise
    except Exception as error:  # trimesh's parsers raise whatever the bytes provoke
        cause = f"{type(error).__name__}: {error}".splitlines()[0]
        raise refusal(where, f"is not a readable {kind.upper()} file ({cause}).") from error


def _flatten(where: str, scene: trimesh.Scene) -> tuple[Array, Faces]:
    """Join the parts of a scene in its frame, counting first: instances multiply cheaply."""
    import trimesh  # late, as above

    placed = [scene.graph[node] for node in scene.graph.nodes_geometry]
    parts = [(pose, scene.geometry[name]) for pose, name in placed]
    parts = [(pose, part) for pose, part in parts if isinstance(part, trimesh.Trimesh)]
    count = sum(len(part.faces) for _, part in parts)
    if count > MAX_TRIANGLES:
        raise refusal(where, f"has more than {MAX_TRIANGLES} triangles.", "Simplify the mesh.")
    if not count:
        raise refusal(where, "has no faces.", "Export triangles, not points or curves.")
    offsets = np.cumsum([0, *(len(part.vertices) for _, part in parts)])
    vertices = [np.asarray(part.vertices) @ pose[:3, :3].T + pose[:3, 3] for pose, part in parts]
    faces = [_sound(where, part) + first for (_, part), first in zip(parts, offsets, strict=False)]
    return np.concatenate(vertices).astype(np.float64), np.concatenate(faces)


def _sound(where: str, part: trimesh.Trimesh) -> Faces:
    faces = np.asarray(part.faces, dtype=np.int64)
    if faces.size and (faces.min() < 0 or faces.max() >= len(part.vertices)):
        raise refusal(where, "has a face with a vertex that does not exist.", "Export it again.")
    return faces


def check(where: str, vertices: Array, faces: Faces) -> None:
    """Refuse vertices (n, 3) that nobody can compute with.

    Raises:
        InputError: If one is not finite, or so far away that volumes lose their meaning.
    """
    if not np.isfinite(vertices).all():
        raise refusal(where, "has a vertex that is not a finite number.", "Export it again.")
    if np.abs(vertices[faces]).max() > MAX_COORDINATE:
        raise refusal(where, f"reaches farther than {MAX_COORDINATE:g} m.", "Export it again.")


def suspicions(where: str, vertices: Array, parts: Components) -> tuple[str, ...]:
    """Say what is usable about a mesh of vertices (n, 3), yet probably not meant."""
    found = []
    if not parts.volume.all():
        found.append(f"{where}: is not watertight. Where it is open, only its surface collides.")
    extent = np.ptp(vertices, axis=0).max()
    if extent > MAX_EXTENT:
        found.append(f"{where}: is {extent:.4g} m wide. Millimetres? Then write scale = 0.001.")
    return tuple(found)
