"""Obstacles that move are met by those that they are paired with, and by nothing else."""

import numpy as np
import pytest

from kinolab.dynamics import Box, Sphere
from kinolab.dynamics.facts.machine_facts import BodyGeometry
from kinolab.world import CollisionChecker, World, box_obstacle
from kinolab.world.collision.clearance_bound import ClearanceBound
from kinolab.world.collision.collision_scene import collision_scene

BALL = BodyGeometry("ball", (Sphere(0.2),))
CART = BodyGeometry("cart", (Box(0.4, 0.4, 0.4),), moves=False, prescribed=True)
WALL = box_obstacle("wall", (1.0, 1.0, 1.0), (0.0, 0.0, 0.5))
PAIRS = [("ball", "cart")]
NOWHERE = np.zeros((0, 6))


def poses(ball: tuple[float, float, float], cart: tuple[float, float, float]) -> np.ndarray:
    table = np.tile(np.eye(3, 4), (2, 1, 1))
    table[0, :, 3], table[1, :, 3] = ball, cart
    return table.reshape(2, 12)


def gap(ball: np.ndarray, cart: np.ndarray) -> float:
    """From a ball of 0.2 m to an upright cube of 0.4 m, by the point of it that is nearest."""
    nearest = np.clip(ball, cart - 0.2, cart + 0.2)
    return float(np.linalg.norm(ball - nearest)) - 0.2


def test_an_obstacle_passes_through_walls_and_the_ground() -> None:
    world = World((WALL,), ground=True)
    checker = CollisionChecker([BALL, CART], world, self_pairs=PAIRS)
    through = poses((5.0, 0.0, 1.0), (0.3, 0.0, 0.1))
    assert not checker.collides(through)
    assert checker.contacts(through) == []
    assert checker.collides(poses((0.3, 0.0, 1.0), (5.0, 0.0, 0.1)))


@pytest.mark.parametrize("kept", [0.0, 0.15])
def test_clearance_between_two_that_move(kept: float) -> None:
    """Half of the gap beyond what must be left, as each may go half the way."""
    world = World(clearance=kept)
    checker = CollisionChecker([BALL, CART], world, self_pairs=PAIRS)
    bound = ClearanceBound(collision_scene([BALL, CART], world, self_pairs=PAIRS))
    generator = np.random.default_rng(0)
    for _ in range(200):
        ball, cart = generator.uniform(-1.0, 1.0, (2, 3))
        table, true = poses(tuple(ball), tuple(cart)), (gap(ball, cart) - kept) / 2
        assert checker.collides(table) == (true < 0.0)
        assert checker.clearance(table) == pytest.approx(max(true, 0.0), abs=1e-7)
        found = bound.within(table, NOWHERE, 10.0)
        assert found <= max(true, 0.0) + 1e-12
        assert found >= true - 1e-4 or true < 0.0


def test_what_is_too_near_is_named() -> None:
    checker = CollisionChecker([BALL, CART], World(clearance=0.15), self_pairs=PAIRS)
    (contact,) = checker.contacts(poses((0.5, 0.0, 0.0), (0.0, 0.0, 0.0)))
    assert (contact.body, contact.obstacle, contact.kind) == ("ball", "cart", "near")
    assert checker.contacts(poses((0.6, 0.0, 0.0), (0.0, 0.0, 0.0))) == []
