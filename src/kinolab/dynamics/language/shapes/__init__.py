"""Convex shapes of bodies, for rendering and collision checking, and meshes that are only drawn."""

from kinolab.dynamics.language.shapes.drawn_mesh import DrawnMesh as DrawnMesh
from kinolab.dynamics.language.shapes.shape import MAX_COORDINATE as MAX_COORDINATE
from kinolab.dynamics.language.shapes.shape import ORIGIN as ORIGIN
from kinolab.dynamics.language.shapes.shape import AxisName as AxisName
from kinolab.dynamics.language.shapes.shape import Hull as Hull
from kinolab.dynamics.language.shapes.shape import Point as Point
from kinolab.dynamics.language.shapes.shape import Scalar as Scalar
from kinolab.dynamics.language.shapes.shape import Shape as Shape
from kinolab.dynamics.language.shapes.shape import ShapeKind as ShapeKind
from kinolab.dynamics.language.shapes.solids import SHAPES as SHAPES
from kinolab.dynamics.language.shapes.solids import Box as Box
from kinolab.dynamics.language.shapes.solids import Capsule as Capsule
from kinolab.dynamics.language.shapes.solids import Cylinder as Cylinder
from kinolab.dynamics.language.shapes.solids import Disk as Disk
from kinolab.dynamics.language.shapes.solids import Sphere as Sphere
