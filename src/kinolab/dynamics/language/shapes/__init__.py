"""Convex shapes of bodies, for rendering and collision checking, and meshes that are only drawn."""

from kinolab.dynamics.language.shapes.drawn_mesh import DrawnMesh
from kinolab.dynamics.language.shapes.shape import (
    MAX_COORDINATE,
    ORIGIN,
    AxisName,
    Hull,
    Point,
    Scalar,
    Shape,
    ShapeKind,
)
from kinolab.dynamics.language.shapes.solids import SHAPES, Box, Capsule, Cylinder, Disk, Sphere

__all__ = [
    "MAX_COORDINATE",
    "ORIGIN",
    "SHAPES",
    "AxisName",
    "Box",
    "Capsule",
    "Cylinder",
    "Disk",
    "DrawnMesh",
    "Hull",
    "Point",
    "Scalar",
    "Shape",
    "ShapeKind",
    "Sphere",
]
