"""Mass properties of solids of one density: of shapes in closed form, of meshes by their faces.

Source: Blow, Binstock, How to find the inertia tensor (or other mass properties) of a 3D solid body
represented by a triangle mesh, 2004.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kinolab.numerics.arrays import Array
from kinolab.robots.kinematic_tree import Inertial
from kinolab.world.meshes.mesh_components import components
from kinolab.world.shape_surfaces import Faces


def box_mass(edges: Sequence[float], density: float) -> Inertial:
    """Return the mass properties of a box of three edges in [m], of a density in [kg/m^3]."""
    x, y, z = edges
    mass, moments = density * x * y * z, (y * y + z * z, x * x + z * z, x * x + y * y)
    return _centred(mass, [mass * each / 12.0 for each in moments])


def cylinder_mass(radius: float, length: float, density: float) -> Inertial:
    """Return the mass properties of a cylinder along z, in [m], of a density in [kg/m^3]."""
    mass = density * math.pi * radius**2 * length
    across = mass * (3.0 * radius**2 + length**2) / 12.0
    return _centred(mass, [across, across, mass * radius**2 / 2.0])


def ball_mass(radius: float, density: float) -> Inertial:
    """Return the mass properties of a ball of a radius in [m], of a density in [kg/m^3]."""
    mass = density * 4.0 / 3.0 * math.pi * radius**3
    return _centred(mass, [0.4 * mass * radius**2] * 3)


def _centred(mass: float, moments: Sequence[float]) -> Inertial:
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
