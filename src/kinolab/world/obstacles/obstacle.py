"""Obstacles: the things in the world that do not move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from kinolab.dynamics.language.shapes import MAX_COORDINATE, Box, Capsule, Cylinder, Shape, Sphere
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.untrusted import ELEMENTS
from kinolab.world.meshes.mesh import check, load_mesh
from kinolab.world.meshes.mesh_components import Components, components
from kinolab.world.meshes.mesh_hints import doubts
from kinolab.world.meshes.mesh_reading import refusal
from kinolab.world.shapes.geometry import frame_in_world, half_extents, sizes, triangles
from kinolab.world.shapes.shape_surfaces import Faces

Numbers = Sequence[float]
ORIGIN: Numbers = (0.0, 0.0, 0.0)

# What becomes of the axes of a mesh file so that the named one points up; all right-handed.
UPRIGHT: dict[str, Array] = {
    "x": np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]),
    "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "z": np.eye(3),
}

OCTAHEDRON: Faces = np.array(
    [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
)


@dataclass(frozen=True, eq=False, repr=False)
class Obstacle:
    """One thing to stay clear of, in world coordinates.

    A ``solid`` fills its closed parts whose faces look outward; otherwise only the surface
    collides. A ``primitive`` is an exact shape at a pose (3, 4), of which the triangles are the
    picture.
    """

    name: str
    vertices: Array  # (n, 3), [m]
    faces: Faces  # (m, 3)
    primitive: tuple[Shape, Array] | None = None
    solid: bool = True
    source: Path | None = None  # the mesh file
    warnings: tuple[str, ...] = ()
    parts: Components | None = None  # of a mesh, where they are known already
    colors: Array | None = None  # (m, 3) red, green, blue in 0..1 of a file that has some
    error: float = 0.0  # [m] by which a mesh that was simplified may stand out of its triangles
    moved_from: Obstacle | None = None  # the same where it stood when the world was built
    # [m] around each vertex of a cloud, whose faces are its points, three times each; 0: a mesh
    ball: float = 0.0
    told: str = ""  # what it is, where its kind does not say that
    remedy: str = ""  # for those that begin or end where it is

    def __str__(self) -> str:
        """What it is: its name, and its kind."""
        if self.told:
            return f"{self.name}: {self.told}"
        if self.primitive is not None:
            return f"{self.name}: {type(self.primitive[0]).__name__.lower()}"
        origin = f" from {self.source.name}" if self.source else ""
        filling = "solid" if self.solid else "surface only"
        return f"{self.name}: mesh of {len(self.faces)} triangles{origin}, {filling}"

    def __repr__(self) -> str:
        """Say in a line what it is, and where."""
        low, high = (", ".join(f"{x:.4g}" for x in corner) for corner in self.bounding_box())
        return f"<Obstacle {self}, from ({low}) to ({high}) m>"

    def bounding_box(self) -> tuple[Array, Array]:
        """Return the lowest and highest (x, y, z) in [m]; of a primitive exactly."""
        if self.primitive is None:
            return self.vertices.min(axis=0) - self.ball, self.vertices.max(axis=0) + self.ball
        turn, center = frame_in_world(*self.primitive)
        low, high = (half_extents(self.primitive[0], sign * turn) for sign in (-1.0, 1.0))
        return center - low, center + high

    def picture(self) -> tuple[Array, Faces]:
        """Return what is drawn of it: vertices (n, 3) in [m] and faces (m, 3).

        A cloud is drawn as octahedra: of 25 000 points a page is some megabytes large, and where it
        has more, points at equal steps are drawn.
        """
        if self.ball == 0.0:
            return self.vertices, self.faces
        points = self.vertices[:: -(-len(self.vertices) // 25_000)]
        tips = self.ball * np.concatenate([np.eye(3), -np.eye(3)])
        faces = len(tips) * np.arange(len(points))[:, None, None] + OCTAHEDRON
        return (points[:, None] + tips).reshape(-1, 3), faces.reshape(-1, 3)


def rotation(rpy: Numbers) -> Array:
    """Turn by roll, pitch and yaw in [rad] about the fixed axes x, y and z, in this order.

    Returns:
        Rz(yaw) Ry(pitch) Rx(roll), shape (3, 3).
    """
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    about_y = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    about_z = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(about_z @ about_y @ about_x)


def box_obstacle(
    name: str, edges: Numbers, position: Numbers = ORIGIN, rpy: Numbers = ORIGIN
) -> Obstacle:
    """Make a box with full ``edges`` (3,) in [m], its centre at ``position`` in [m]."""
    _require_positive(name, "edges", edges)
    x, y, z = map(float, edges)
    return _primitive(name, Box(x, y, z), position, rpy)


def sphere_obstacle(
    name: str, radius: float, position: Numbers = ORIGIN, rpy: Numbers = ORIGIN
) -> Obstacle:
    """Make a ball with its centre at ``position``; both in [m]. Turning it shows nowhere."""
    _require_positive(name, "radius", [radius])
    return _primitive(name, Sphere(float(radius)), position, rpy)


def cylinder_obstacle(
    name: str, radius: float, length: float, position: Numbers = ORIGIN, rpy: Numbers = ORIGIN
) -> Obstacle:
    """Make a cylinder along z before ``rpy`` turns it; radius and full length in [m]."""
    _require_positive(name, "radius and length", [radius, length])
    return _primitive(name, Cylinder(float(radius), float(length)), position, rpy)


def capsule_obstacle(
    name: str, radius: float, length: float, position: Numbers = ORIGIN, rpy: Numbers = ORIGIN
) -> Obstacle:
    """Make a cylinder along z with half a ball on each end, before ``rpy`` turns it.

    Radius and the length between the balls' centres are in [m].
    """
    _require_positive(name, "radius and length", [radius, length])
    return _primitive(name, Capsule(float(radius), float(length)), position, rpy)


def mesh_obstacle(
    name: str,
    path: str | Path,
    root: Path,
    position: Numbers = ORIGIN,
    rpy: Numbers = ORIGIN,
    *,
    scale: float | Numbers = 1.0,
    up: Literal["x", "y", "z"] = "z",
    solid: bool | None = None,
    most: int = ELEMENTS["triangles"],
) -> Obstacle:
    """Read a mesh and place it: first ``scale``, then ``up``, then ``rpy``, then ``position``.

    Args:
        name: What the user calls it in reports.
        path: The mesh file, looked up from ``root``, which it may not leave.
        position: Where the file's origin goes, [m].
        rpy: Roll, pitch, yaw in [rad].
        scale: One factor, or one per axis of the file; negative ones mirror.
        up: The axis of the file that points up.
        solid: Fill every closed part (True) or none (False). By default a part whose faces look
            outward is filled, and one whose faces look inward is a room.
        most: Triangles that the file may have.

    Raises:
        InputError: If the file is unusable, ``scale`` is zero, or ``solid`` is asked of an open
            mesh.
    """
    mesh = load_mesh(path, root=root, most=most)
    linear = upright(name, scale, up)
    pose = placed(name, position, rpy)
    vertices = mesh.vertices @ (pose[:, :3] @ linear).T + pose[:, 3]
    check(str(path), vertices, mesh.faces)
    faces = mesh.faces if np.linalg.det(linear) > 0 else mesh.faces[:, ::-1]
    parts = components(vertices, faces, mesh.label)
    if solid is None:  # faces that look both ways do not say on which side the solid lies
        parts.volume[parts.label[mesh.both]] = 0.0
    faces, filled = _fill(str(path), faces, parts, solid)
    known = {"given": solid is not None, "scaled": scale != 1.0}
    warnings = tuple(doubts(str(path), mesh, vertices, parts, up=up, **known))
    if solid:
        parts = parts._replace(volume=np.abs(parts.volume))  # all faces look outward now
    colors = mesh.colors / 255.0 if len(mesh.colors) else None
    return Obstacle(
        name,
        vertices,
        np.ascontiguousarray(faces),
        None,
        filled,
        (root / path).resolve(),
        warnings,
        parts,
        colors,
    )


def _primitive(name: str, shape: Shape, position: Numbers, rpy: Numbers) -> Obstacle:
    pose = placed(name, position, rpy)
    farthest = float(max(np.abs(pose[:, 3]).max(), 2.0 * sizes(shape)[1].max()))
    if farthest > MAX_COORDINATE:
        what = f"its position or size is {farthest:g} m."
        raise InputError([Mistake(name, what, f"Stay within {MAX_COORDINATE:g} m.")])
    vertices, faces = triangles(shape)
    return Obstacle(name, vertices @ pose[:, :3].T + pose[:, 3], faces, (shape, pose))


def placed(name: str, position: Numbers, rpy: Numbers) -> Array:
    """Return the pose (3, 4) of a position in [m] and roll, pitch and yaw in [rad].

    Raises:
        InputError: If one of them is not finite.
    """
    pose = np.array([*position, *rpy], dtype=float)
    if not np.isfinite(pose).all():
        raise InputError([Mistake(name, "position and rpy must be finite numbers.")])
    return np.column_stack([rotation(rpy), pose[:3]])


def _fill(where: str, faces: Faces, parts: Components, solid: bool | None) -> tuple[Faces, bool]:
    """Decide whether the mesh is solid, and turn the faces outward where the user says it is."""
    if solid is None:
        return faces, bool((parts.volume > 0).any())
    if solid and not parts.volume.all():
        raise refusal(
            where,
            "is not watertight, so it cannot be solid.",
            "Close its holes and let all faces look outward, or leave out solid.",
        )
    inward = parts.volume[parts.label] < 0
    return np.where(inward[:, None], faces[:, ::-1], faces) if solid else faces, solid


def upright(name: str, scale: float | Numbers, up: Literal["x", "y", "z"]) -> Array:
    """Return the matrix (3, 3) that scales the axes of a file and lets the named one point up.

    Raises:
        InputError: If a factor is not finite, or 0.
    """
    factors = np.broadcast_to(np.asarray(scale, dtype=float), (3,))
    if not (np.isfinite(factors).all() and factors.all()):
        raise InputError([Mistake(name, "scale must be finite and not 0.", "1 leaves the size.")])
    return UPRIGHT[up] @ np.diag(factors)


def _require_positive(name: str, what: str, values: Numbers) -> None:
    if not all(np.isfinite(value) and value > 0 for value in values):
        raise InputError([Mistake(name, f"{what} must be positive.", "Lengths are in metres.")])
