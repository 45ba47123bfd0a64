"""Worlds of many obstacles: what is passed over is far away, and what is looked at is in order."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.dynamics.facts.machine_facts import BodyGeometry
from kinolab.dynamics.language.shapes import Sphere
from kinolab.numerics.arrays import Array
from kinolab.numerics.struct import Record
from kinolab.world import CollisionChecker, Obstacle, World, box_obstacle
from kinolab.world.collision.clearance_bound import ClearanceBound
from kinolab.world.collision.collision_scene import collision_scene
from kinolab.world.distances.gjk import box_gap
from kinolab.world.distances.obstacle_blocks import following
from kinolab.world.distances.placed_shapes import MANY, near_each_other, obstacle_arrays
from kinolab.world.distances.triangle_gaps import TOUCHING_MARGIN
from kinolab.world.obstacles.redundant_obstacles import without_redundant

RADIUS = 0.3  # [m] of the ball that moves


def city(count: int, seed: int = 0, side: float = 60.0) -> list[Obstacle]:
    random = np.random.default_rng(seed)
    at, edges = random.uniform(0.0, side, (count, 3)), random.uniform(0.1, 0.6, (count, 3))
    at[:, 2] /= 10.0
    return [
        box_obstacle(f"box {k}", size, place)
        for k, (size, place) in enumerate(zip(edges.tolist(), at.tolist(), strict=True))
    ]


def poses(count: int, side: float = 60.0) -> Array:
    """Places of the ball, shape (count, 1, 12)."""
    table = np.zeros((count, 1, 12))
    table[:, 0, [0, 5, 10]] = 1.0
    places = np.random.default_rng(9).uniform(0.0, side, (count, 3))
    table[:, 0, 3::4] = places * [1.0, 1.0, 0.1]
    return table


def gaps(obstacles: list[Obstacle], place: Array) -> Array:
    """Distances of a point to axis-aligned boxes, in closed form, in [m]."""
    box = obstacle_arrays(obstacles).box
    return np.linalg.norm(np.maximum(np.maximum(box[:, :3] - place, place - box[:, 3:]), 0), axis=1)


@pytest.mark.parametrize("count", [0, 1, 32, 33, 1024, 1025, 5000])
def test_every_near_obstacle_is_found_in_order(count: int) -> None:
    arrays = obstacle_arrays(city(count))
    record = Record(arrays)
    random = np.random.default_rng(1)
    for reach in (1e-300, 0.5, 5.0):
        low = random.uniform(0.0, 60.0, 3) * [1.0, 1.0, 0.1]
        box = np.concatenate([low, low + 0.5])
        near = [k for k in range(count) if box_gap(box, arrays.box[k]) < reach]
        looked, k = [], following(0, box, reach, record)
        while k < count:
            looked.append(k)
            k = following(k + 1, box, reach, record)
        assert looked == sorted(looked)
        assert {*near} <= {*looked}


def test_neighbours_follow_each_other_in_worlds_of_many() -> None:
    few, many = city(MANY), city(MANY + 1)
    assert near_each_other(few) is few
    ordered = near_each_other(many)
    assert {*map(id, ordered)} == {*map(id, many)}
    blocks = [obstacle_arrays(each).blocks[:62] for each in (many, ordered)]  # full ones
    sizes = [np.prod(box[:, 3:5] - box[:, :2], axis=1).mean() for box in blocks]
    assert sizes[1] < sizes[0] / 10.0


BALL = BodyGeometry("ball", (Sphere(RADIUS),))


def test_clearance_among_many_boxes_is_that_to_the_nearest() -> None:
    obstacles = [*near_each_other(city(4000))]
    world = World(tuple(obstacles))
    checker, room = CollisionChecker([BALL], world), ClearanceBound(collision_scene([BALL], world))
    hits = 0
    for table in poses(300):
        known = gaps(obstacles, table[0, 3::4]).min() - RADIUS
        hits += known < 0.0
        if abs(known) > 2.0 * TOUCHING_MARGIN:
            assert checker.collides(table) == (known < 0.0)
        assert checker.clearance(table) == pytest.approx(max(known, 0.0), abs=1e-8)  # [m]
        if known > 2.0 * TOUCHING_MARGIN:
            found = room.within(table, np.zeros(0), 0.3)
            assert found == pytest.approx(min(known, 0.3), abs=2.0 * TOUCHING_MARGIN)
        touched = {contact.obstacle for contact in checker.contacts(table)}
        sure = np.flatnonzero(gaps(obstacles, table[0, 3::4]) < RADIUS - TOUCHING_MARGIN)
        assert {obstacles[k].name for k in sure} <= touched
    assert 20 < hits < 280


def test_what_is_inside_of_a_larger_box_is_left_out_of_many() -> None:
    obstacles = city(600, side=8.0)
    box = obstacle_arrays(obstacles).box
    lies_in = (box[None, :, :3] <= box[:, None, :3]) & (box[:, None, 3:] <= box[None, :, 3:])
    hidden = (lies_in.all(axis=2) & ~np.eye(600, dtype=bool)).any(axis=1)
    assert 0 < hidden.sum() < 600
    kept = without_redundant(obstacles)
    assert [o.name for o in kept] == [
        o.name for o, h in zip(obstacles, hidden, strict=True) if not h
    ]
