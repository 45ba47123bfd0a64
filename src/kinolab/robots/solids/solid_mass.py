"""Mass properties of solids of one density: of shapes in closed form, of meshes by trimesh."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.spatial import QhullError

from kinolab.numerics.arrays import Array
from kinolab.robots.tree.kinematic_tree import Inertial
from kinolab.world.meshes.mesh_components import components
from kinolab.world.shapes.shape_surfaces import Faces


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
    import trimesh  # late: it takes long to import

    middle = vertices.mean(axis=0)
    solid = trimesh.Trimesh(vertices - middle, faces, process=False)
    if not components(vertices, faces).volume.all():
        try:
            solid = solid.convex_hull
        except QhullError:
            return None
    found = trimesh.triangles.mass_properties(solid.triangles, density=density)
    if found.volume == 0.0:
        return None
    sign = math.copysign(1.0, found.volume)  # where all faces look inward, all is negative
    centre = middle + found.center_mass
    return Inertial(sign * float(found.mass), centre, sign * np.asarray(found.inertia))
