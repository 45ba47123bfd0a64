"""Capsules in the world: a ball's clearance beside one is known in closed form."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.errors import InputError
from kinolab.world import capsule_obstacle
from kinolab.world.distances.distance_field import distance_field
from kinolab.world.obstacles.obstacle import rotation

RADIUS, LENGTH, AT, RPY = 0.3, 0.8, (1.0, 0.5, 0.4), (0.7, 0.4, -0.3)


def to_axis(points: np.ndarray) -> np.ndarray:
    """Distances (n,) of points (n, 3) to the capsule's axis, in [m]."""
    local = (points - AT) @ rotation(RPY)
    beyond = np.maximum(np.abs(local) - [0.0, 0.0, 0.5 * LENGTH], 0.0)
    return np.linalg.norm(beyond, axis=1)


def test_a_scenario_s_capsule_collides_where_it_is() -> None:
    table: dict[str, Any] = {
        "system": "unicycle",
        "goal": {"x": 3.0},
        "bounds": {"x": [0, 5], "y": [0, 5]},
        "world": {"obstacle": [{"capsule": [RADIUS, LENGTH], "position": [*AT], "rpy": [*RPY]}]},
    }
    problem = kinolab.load(table)
    (capsule,) = problem.world.obstacles
    assert str(capsule) == "capsule 1: capsule"
    again = problem.with_obstacle("beside", capsule=[0.1, 0.2], position=(3.0, 3.0, 0.2))
    assert len(again.world.obstacles) == 2


def test_a_grid_s_distances_are_never_more_than_the_true_ones() -> None:
    field = distance_field([capsule_obstacle("pill", RADIUS, LENGTH, AT, RPY)], finest=0.05)
    index = np.stack(np.meshgrid(*map(np.arange, field.distance.shape), indexing="ij"), axis=-1)
    centres = field.low + (index[..., ::-1].reshape(-1, 3) + 0.5) * field.width
    true = np.maximum(to_axis(centres) - RADIUS, 0.0)
    found = field.distance.ravel()
    assert (found <= true + 1e-6).all()  # [m]; the grid keeps single precision
    assert (found >= true - 2.0 * field.width).all()
    assert (found > 0.0).any()


@pytest.mark.parametrize("radius", [0.0, -0.1, float("nan")])
def test_a_capsule_without_a_size_is_refused(radius: float) -> None:
    with pytest.raises(InputError, match="radius and length"):
        capsule_obstacle("pill", radius, 1.0)
