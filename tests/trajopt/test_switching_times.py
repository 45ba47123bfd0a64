"""Switching-time optimisation finds the curves of Reeds and Shepp, and nothing shorter."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest

import kinolab
from benchmarks.exact_optima import Optimum, reeds_shepp_cars
from kinolab.dynamics import Body, Drive, Rate, System, length, move
from kinolab.trajopt.multistart.driftless import is_driftless
from kinolab.trajopt.multistart.switching_times import SwitchingTimes

CARS = list(islice(reeds_shepp_cars(11), 6))


def shortest(car: Optimum, below: float, **changes: object) -> kinolab.Trajectory | None:
    problem = kinolab.load({**car.scenario, **changes})
    return SwitchingTimes(problem, np.random.default_rng(0), lambda: False, below).next()


@pytest.mark.parametrize("car", CARS, ids=lambda car: car.name)
def test_a_car_takes_the_shortest_of_all_curves(car: Optimum) -> None:
    """One batch of words misses the best one for some goals; by how much is bounded by 10 %."""
    motion = shortest(car, 1.3 * car.duration)
    assert motion is not None
    assert (1 - 1e-6) * car.duration <= motion.duration < 1.1 * car.duration
    problem = kinolab.load(car.scenario)
    assert kinolab.verify(problem, motion).passed
    assert problem.goal_distance(motion.x[-1]) < 1e-6  # [m], [rad]


def test_most_cars_take_exactly_the_shortest_curve() -> None:
    found = [shortest(car, 1.3 * car.duration) for car in CARS]
    exact = [
        m is not None and m.duration < (1 + 1e-6) * c.duration
        for m, c in zip(found, CARS, strict=True)
    ]
    assert sum(exact) >= len(CARS) / 2


def test_nothing_is_shorter_than_the_shortest() -> None:
    assert shortest(CARS[0], (1 - 1e-6) * CARS[0].duration) is None


def test_a_curve_through_a_wall_is_dropped() -> None:
    """Only the wall's own thickness is in the way, from bound to bound."""
    x, y = CARS[0].scenario["goal"]["x"], CARS[0].scenario["goal"]["y"]
    wall = {"box": [0.01, 100.0, 1.0], "position": [x / 2, y / 2, 0.0]}
    world = {**CARS[0].scenario["world"], "obstacle": [wall]}
    assert shortest(CARS[0], 10.0, world=world) is None


def test_only_machines_that_stand_without_inputs_are_driftless() -> None:
    x = length("x", -1.0, 1.0, speed=1.0)
    cart = Body("cart", move(x), mass=1.0)
    table = {"goal": {"x": 0.5, "tolerance": 0.1}}
    moved = System("moved", bodies=[cart], inputs=[Rate("v", on=x, limit=1.0)])
    pushed = System("pushed", bodies=[cart], inputs=[Drive("a", on=x, limit=1.0)])
    assert is_driftless(kinolab.load({"system": moved, **table}))
    assert not is_driftless(kinolab.load({"system": pushed, **table}))
