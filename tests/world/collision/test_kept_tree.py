"""The tree of a world's triangles: built once for the same meshes, anew for others."""

from __future__ import annotations

import numpy as np

from kinolab.world import Obstacle, box_obstacle
from kinolab.world.distances.triangle_grid import mesh_grid
from kinolab.world.distances.triangle_tree import mesh_tree, triangle_tree


def mesh(x: float) -> Obstacle:
    box = box_obstacle("box", (1.0, 1.0, 1.0), (x, 0.0, 0.5))
    return Obstacle("mesh", box.vertices, box.faces)


def test_the_same_meshes_share_a_tree_and_others_have_their_own() -> None:
    a, b, primitive = mesh(0.0), mesh(3.0), box_obstacle("box", (1.0, 1.0, 1.0))
    assert mesh_tree([a, b]) is mesh_tree([a, primitive, b])
    worlds: list[list[Obstacle]] = [[a], [a, b], [b, a], [b], [primitive], []]
    for world in (*worlds, *worlds):
        meshes = [obstacle for obstacle in world if obstacle is not primitive]
        anew = triangle_tree(mesh_grid(meshes).triangles)
        for kept, made in zip(mesh_tree(world), anew, strict=True):
            np.testing.assert_array_equal(kept, made)
