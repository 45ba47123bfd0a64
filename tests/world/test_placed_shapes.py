"""Obstacles in arrays: as each of them says one by one, and gathered once for the same company."""

from __future__ import annotations

import gc
from weakref import ref

import numpy as np

from kinolab.dynamics.language.shapes import Box, Capsule, Cylinder, Disk, Shape, Sphere
from kinolab.world import Obstacle, box_obstacle, lowest_z
from kinolab.world.distances.placed_shapes import lowest_heights, obstacle_arrays
from kinolab.world.obstacles.kept_together import kept_together
from kinolab.world.obstacles.obstacle import cylinder_obstacle, rotation, sphere_obstacle
from kinolab.world.shapes.geometry import frame_in_world, sizes

SHAPES: tuple[Shape, ...] = (
    Box(1.0, 2.0, 3.0, at=(0.1, 0.2, 0.3)),
    Sphere(0.5, at=(0.0, 0.3, 0.0)),
    Cylinder(0.5, 2.0, axis="x", at=(0.2, 0.0, 0.0)),
    Capsule(0.3, 1.5, axis="y"),
    Disk(0.4, thickness=0.1, axis="y"),
)


def pose(generator: np.random.Generator) -> np.ndarray:
    turn, at = generator.uniform(-3.0, 3.0, (2, 3))
    return np.column_stack([rotation(turn.tolist()), at])


def obstacles() -> list[Obstacle]:
    """Primitives of every kind, as scenarios and other files place them, and two meshes."""
    generator = np.random.default_rng(0)
    solid = box_obstacle("box", (1.0, 2.0, 0.5), (3.0, 1.0, 0.0), (0.1, 0.2, 0.3))
    none = np.zeros((0, 3))
    placed = [
        Obstacle(f"shape {k}", none, none.astype(np.int64), (shape, pose(generator)))
        for k, shape in enumerate(SHAPES)
    ]
    meshes = [Obstacle(f"mesh {k}", solid.vertices + k, solid.faces) for k in range(2)]
    return [
        meshes[0],
        solid,
        *placed,
        meshes[1],
        sphere_obstacle("ball", 0.5, (1.0, 0.0, 0.0)),
        cylinder_obstacle("post", 0.2, 2.0, (0.0, 1.0, 1.0), (0.0, 0.5, 0.0)),
    ]


def test_arrays_hold_what_each_obstacle_says() -> None:
    """Places agree but for rounding, in the last bit; all else is the same."""
    world = obstacles()
    arrays = obstacle_arrays(world)
    meshes = 0
    for k, obstacle in enumerate(world):
        np.testing.assert_allclose(
            arrays.box[k], np.concatenate(obstacle.bounding_box()), rtol=1e-15, atol=1e-15
        )
        if obstacle.primitive is None:
            assert arrays.mesh[k] == meshes
            meshes += 1
            continue
        kind, half = sizes(obstacle.primitive[0])
        turn, at = frame_in_world(*obstacle.primitive)
        assert (arrays.mesh[k], arrays.kind[k]) == (-1, kind)
        np.testing.assert_array_equal(arrays.half[k], half)
        np.testing.assert_array_equal(arrays.turn[k], turn)
        np.testing.assert_allclose(arrays.at[k], at, rtol=1e-15, atol=1e-15)


def test_no_obstacle_makes_empty_arrays() -> None:
    shapes = [numbers.shape for numbers in obstacle_arrays(())]
    assert shapes == [(0,), (0, 3), (0, 3, 3), (0, 3), (0, 6), (0,), (0, 6), (0,)]


def test_lowest_heights_are_those_of_single_poses() -> None:
    generator = np.random.default_rng(1)
    poses = np.array([pose(generator) for _ in range(20)])
    for shape in SHAPES:
        single = [lowest_z(shape, one) for one in poses]
        np.testing.assert_allclose(lowest_heights(shape, poses), single, rtol=0, atol=1e-14)  # [m]


def test_what_is_kept_is_made_once_for_a_company_and_goes_with_it() -> None:
    a, b = obstacles()[:2]
    made: list[int] = []

    class Made:
        pass

    def make(_company: object) -> Made:
        made.append(1)
        return Made()

    kept = kept_together(make)
    assert kept([a, b]) is kept((a, b))
    assert kept([a]) is not kept([a, b])
    assert kept([b, a]) is kept([b, a])
    assert kept([]) is kept(())
    assert len(made) == 5  # [a, b], [a], [a, b] again, [b, a], none
    last = ref(kept([a]))
    del a, b
    gc.collect()
    assert last() is None
