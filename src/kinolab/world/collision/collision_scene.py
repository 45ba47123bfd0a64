"""A machine among the obstacles of its world, in flat arrays for compiled code."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kinolab.dynamics.facts.machine_facts import BodyGeometry, CableGeometry
from kinolab.numerics.arrays import Integers
from kinolab.world.collision.broadphase import BroadphaseScene, make_broadphase
from kinolab.world.distances.distance_field import DistanceField
from kinolab.world.distances.distance_field_cache import shared_distance_field
from kinolab.world.distances.placed_shapes import ObstacleArrays, obstacle_arrays
from kinolab.world.distances.sphere_tree import SphereTree, sphere_tree
from kinolab.world.distances.triangle_grid import MeshGrid
from kinolab.world.distances.triangle_tree import TriangleTree, mesh_tree
from kinolab.world.obstacles.world import World


class CollisionScene(NamedTuple):
    """A machine's shapes and a world in flat arrays, for compiled code."""

    broadphase: BroadphaseScene
    mesh: MeshGrid
    triangles: TriangleTree
    obstacles: ObstacleArrays
    spheres: SphereTree
    distance: DistanceField  # to obstacles as they stood when the world was built
    loose: Integers  # rows of the obstacles that have moved since
    cable_rows: Integers  # (shapes of cables,) their rows among the ends
    # whether bodies keep their height, so that no motion leads down to the ground
    constant_height: bool
    clearance: float  # [m] that must be left beside obstacles, which is subtracted


def collision_scene(
    bodies: Sequence[BodyGeometry],
    world: World,
    *,
    cables: Sequence[CableGeometry] = (),
    self_pairs: Sequence[tuple[str, str]] = (),
    glides: bool = False,
) -> CollisionScene:
    """Gather what ``clearance_within`` needs; most arguments are those of ``CollisionChecker``."""
    shapes = [shape for body in bodies for shape in body.shapes]
    broadphase, mesh = make_broadphase(bodies, cables, world, self_pairs)
    sizes = broadphase.half[: len(shapes), :3]
    # of a body's smallest half size, as which cells need not be finer
    finest = 0.25 * float(sizes[sizes > 0].min(initial=math.inf))
    built = [obstacle.moved_from or obstacle for obstacle in world.obstacles]
    grid = shared_distance_field(built, finest if math.isfinite(finest) else 0.0)
    loose = [obstacle.moved_from is not None for obstacle in world.obstacles]
    return CollisionScene(
        broadphase,
        mesh,
        mesh_tree(world.obstacles),
        obstacle_arrays(world.obstacles),
        sphere_tree(shapes, grid.width),
        grid,
        np.flatnonzero(loose).astype(np.int64),
        np.flatnonzero([cable.collides for cable in cables]).astype(np.int64),
        glides,
        world.clearance,
    )
