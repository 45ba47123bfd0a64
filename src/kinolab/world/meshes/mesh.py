"""Mesh files that somebody else wrote: read with suspicion, refused with an explanation."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.language.shapes import MAX_COORDINATE
from kinolab.numerics.arrays import Array
from kinolab.untrusted import ELEMENTS, read
from kinolab.world.meshes.double_faces import single_faces
from kinolab.world.meshes.mesh_cache import MESHES, Mesh
from kinolab.world.meshes.mesh_components import connected_parts
from kinolab.world.meshes.mesh_reading import read_triangles, refusal, too_many
from kinolab.world.meshes.obj_materials import materials_file
from kinolab.world.shapes.shape_surfaces import Faces

FORMATS = ("stl", "obj", "ply", "glb", "off", "dae")


def load_mesh(path: str | Path, *, root: Path, most: int | None = None) -> Mesh:
    """Read an STL, OBJ, PLY, GLB, OFF or DAE file from ``root`` or a folder below it.

    Nothing but the file itself is read, and the materials beside an OBJ: textures and remote
    buffers are not followed. Triangles that are there twice are read once.

    Args:
        path: The file; a relative path is taken from ``root``.
        root: The folder of the scenario, which meshes may not leave, not even by a link.
        most: Triangles that it may have; as many as any mesh if left out.

    Raises:
        InputError: If the file is missing, too large, of another format, or not a sound mesh.
    """
    where = str(path)
    file = locate(where, root, FORMATS, "mesh")
    content = read(file, "mesh", where, "Simplify the mesh.")
    library = materials_file(file, content, root)
    materials = library.read_bytes() if library else b""
    about = _format(where), materials, content
    mesh, most = MESHES.find(about), most or ELEMENTS["triangles"]
    if mesh is None:
        mesh = _sound_mesh(where, content, materials, most)
        MESHES.keep(about, mesh)
    elif len(mesh.faces) > most:  # it was kept for a scenario that simplifies it
        raise too_many(where, most)
    return mesh


def _sound_mesh(where: str, content: bytes, materials: bytes, most: int) -> Mesh:
    raw = read_triangles(where, _format(where), content, materials, most)
    check(where, raw.vertices, raw.faces)
    vertices, faces, rows = merge_duplicates(raw.vertices, raw.faces)
    if not len(faces):
        raise refusal(where, "has no triangle with three different corners.")
    single = single_faces(vertices, faces)
    colors = raw.colors[rows[single.rows]] if len(raw.colors) else raw.colors
    return Mesh(
        vertices,
        single.faces,
        connected_parts(len(vertices), single.faces),
        single.both,
        colors,
        np.array([single.copies, single.pairs]),
        np.array([raw.unit, raw.up]),
    )


def _format(where: str) -> str:
    return Path(where).suffix.lower().removeprefix(".")


def merge_duplicates(vertices: Array, faces: Faces) -> tuple[Array, Faces, NDArray[np.int64]]:
    """Merge vertices (n, 3) at the same place; drop faces (m, 3) that this leaves without area.

    Vertices that no face uses go as well: they would widen every bounding box.

    Returns:
        Vertices, faces, and which of the given faces these are.
    """
    used, faces = np.unique(faces, return_inverse=True)
    vertices = vertices[used] + 0.0  # -0.0 becomes 0.0
    distinct, index = np.unique(vertices, axis=0, return_inverse=True)
    merged = index.reshape(-1)[faces.reshape(-1, 3)].astype(np.int64)
    a, b, c = merged.T
    rows = np.flatnonzero((a != b) & (b != c) & (c != a))
    return distinct, merged[rows], rows.astype(np.int64)


def locate(where: str, root: Path, formats: Sequence[str], noun: str) -> Path:
    """Return the file of a path from a root folder, which it may not leave, not even by a link.

    Args:
        where: The path, which is what the file is called in messages.
        formats: Endings that it may have, in small letters.
        noun: What it should be.

    Raises:
        InputError: If it has another ending, lies outside or is missing.
    """
    if _format(where) not in formats:
        known = ", ".join(name.upper() for name in formats)
        raise refusal(
            where, f"is not a {noun} format that kinolab reads.", f"Convert it to {known}."
        )
    try:
        home = root.resolve()
        file = (home / where).resolve()
        inside, exists = file.is_relative_to(home), file.is_file()
    except (OSError, ValueError, RuntimeError) as error:
        raise refusal(where, f"cannot be found ({error}).") from error
    if not inside:
        raise refusal(where, f"lies outside {home}.", f"Copy the {noun} beside its scenario.")
    if not exists:
        raise refusal(
            where, "does not exist.", f"{noun.capitalize()} files are looked up from {home}."
        )
    return file


def check(where: str, vertices: Array, faces: Faces) -> None:
    """Refuse vertices (n, 3) that nobody can compute with.

    Raises:
        InputError: If one is not finite, or so far away that volumes lose their meaning.
    """
    if not np.isfinite(vertices).all():
        raise refusal(where, "has a vertex that is not a finite number.", "Export it again.")
    if np.abs(vertices[faces]).max() > MAX_COORDINATE:
        raise refusal(where, f"reaches farther than {MAX_COORDINATE:g} m.", "Export it again.")
