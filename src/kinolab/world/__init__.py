"""The world a machine moves in: obstacle meshes, contact by FCL, and proved clearance."""

from kinolab.dynamics.machine_facts import BodyGeometry, CableGeometry
from kinolab.world.cable import NO_ENDS
from kinolab.world.collision.checker import CollisionChecker
from kinolab.world.collision.contact_report import Contact
from kinolab.world.geometry import feature_points, lowest_z, triangles
from kinolab.world.meshes.mesh import load_mesh
from kinolab.world.meshes.mesh_cache import Mesh
from kinolab.world.obstacle import (
    Obstacle,
    box_obstacle,
    cylinder_obstacle,
    mesh_obstacle,
    sphere_obstacle,
)
from kinolab.world.world import World

__all__ = [
    "NO_ENDS",
    "BodyGeometry",
    "CableGeometry",
    "CollisionChecker",
    "Contact",
    "Mesh",
    "Obstacle",
    "World",
    "box_obstacle",
    "cylinder_obstacle",
    "feature_points",
    "load_mesh",
    "lowest_z",
    "mesh_obstacle",
    "sphere_obstacle",
    "triangles",
]
