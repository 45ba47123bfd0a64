"""Mass properties of solids of one density: of shapes in closed form, of meshes by their faces.

Source: Blow, Binstock, How to find the inertia tensor (or other mass properties) of a 3D solid body
represented by a triangle mesh, 2004.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kinolab.dynamics.language.shapes import Shape
from kinolab.dynamics.language.shapes.shape import ShapeKind
from kinolab.numerics.arrays import Array
from kinolab.robots.kinematic_tree import Inertial
from kinolab.world.meshes.mesh_components import components
from kinolab.world.shape_surfaces import Faces


def shape_mass(shape: Shape, density: float) -> Inertial | None:
    """Return the mass properties of a box, or of a cylinder or a ball, in its own frame.

    Args:
        shape: With numbers in [m]; None is returned of another one.
        density: In [kg/m^3].
    """
    kind, lengths = shape.lowered()
    match kind:
        case ShapeKind.BOX:
            x, y, z = (2.0 * half for half in lengths)
            mass, own = density * x * y * z, (y * y + z * z, x * x + z * z, x * x + y * y)
            moments = [mass * each / 12.0 for each in own]
        case ShapeKind.CYLINDER:
            r, h = lengths[0], 2.0 * lengths[2]
            mass = density * math.pi * r * r * h
            across = mass * (3.0 * r * r + h * h) / 12.0
            moments = [across, across, mass * r * r / 2.0]
        case ShapeKind.SPHERE:
            r = lengths[0]
            mass = density * 4.0 / 3.0 * math.pi * r**3
            moments = [0.4 * mass * r * r] * 3
        case _:
            return None
    return Inertial(mass, np.zeros(3), np.diag(moments))


def mesh_mass(vertices: Array, faces: Faces, density: float) -> Inertial | None:
    """Return the mass properties of what a mesh encloses, of its convex hull where it has holes.

    Args:
        vertices: In [m], shape (n, 3).
        faces: That look outward, shape (m, 3).
        density: In [kg/m^3].

    Returns:
        In the axes of the vertices; None where it encloses nothing, as if it were flat.
    """
    middle = vertices.mean(axis=0)
    corners = vertices - middle
    if not components(vertices, faces).volume.all():
        try:
            hull = ConvexHull(corners)
        except QhullError:
            return None
        outward = np.einsum("ij,ij->i", np.cross(*_edges(corners[hull.simplices])),
                            hull.equations[:, :3]) > 0.0  # fmt: skip
        faces = np.where(outward[:, None], hull.simplices, hull.simplices[:, ::-1])
    return _of_tetrahedra(corners[faces], middle, density)


def _edges(triangles: Array) -> tuple[Array, Array]:
    """Return two edges of each of n triangles (n, 3, 3)."""
    return triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]


def _of_tetrahedra(triangles: Array, middle: Array, density: float) -> Inertial | None:
    """Return the mass properties of the tetrahedra between a point and n triangles (n, 3, 3)."""
    determinants = np.linalg.det(triangles)
    sums = triangles.sum(axis=1)
    volume = determinants.sum() / 6.0
    if volume == 0.0:
        return None
    centre = determinants @ sums / 24.0 / volume
    squares = np.einsum("n,ni,nj->ij", determinants, sums, sums)
    squares += np.einsum("n,nki,nkj->ij", determinants, triangles, triangles)
    spread = squares / 120.0 - volume * np.outer(centre, centre)  # of x x^T about the centre
    inertia = np.trace(spread) * np.eye(3) - spread
    sign = math.copysign(density, volume)  # where all faces look inward, both are negative
    return Inertial(sign * float(volume), middle + centre, sign * inertia)
