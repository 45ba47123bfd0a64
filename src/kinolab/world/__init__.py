"""The world a machine moves in: obstacle meshes, contact by FCL, and proved clearance."""

from kinolab.dynamics.facts.machine_facts import BodyGeometry as BodyGeometry
from kinolab.dynamics.facts.machine_facts import CableGeometry as CableGeometry
from kinolab.lazy import lazy_package
from kinolab.world.collision.checker import CollisionChecker as CollisionChecker
from kinolab.world.collision.contact_report import Contact as Contact
from kinolab.world.meshes.mesh import load_mesh as load_mesh
from kinolab.world.meshes.mesh_cache import Mesh as Mesh
from kinolab.world.obstacles.obstacle import Obstacle as Obstacle
from kinolab.world.obstacles.obstacle import box_obstacle as box_obstacle
from kinolab.world.obstacles.obstacle import capsule_obstacle as capsule_obstacle
from kinolab.world.obstacles.obstacle import cylinder_obstacle as cylinder_obstacle
from kinolab.world.obstacles.obstacle import mesh_obstacle as mesh_obstacle
from kinolab.world.obstacles.obstacle import sphere_obstacle as sphere_obstacle
from kinolab.world.obstacles.world import World as World
from kinolab.world.shapes.cable import NO_ENDS as NO_ENDS
from kinolab.world.shapes.geometry import feature_points as feature_points
from kinolab.world.shapes.geometry import lowest_z as lowest_z
from kinolab.world.shapes.geometry import triangles as triangles

__all__, *_ = lazy_package(__name__, __file__)  # what it imports as itself
