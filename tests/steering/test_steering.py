"""Whatever steers: motions end where they must, in truth and within all limits of the inputs."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from kinolab import systems
from kinolab.problem import PlanningTask
from kinolab.steering import Maneuver, Steering, cyclic_coordinates, nearest_equilibrium
from tests.scenes import apart, true_states

Scenes = Callable[..., PlanningTask]
Array = np.ndarray

FLAT = {"car": "car", "coin": "rolling_disk", "crane": "crane", "drive": "diff_drive"}


def resting(problem: PlanningTask, seed: int, reach: float) -> Iterator[Array]:
    """Two equilibria about the middle of a scene, in which much is possible."""
    generator = np.random.default_rng(seed)
    lower, upper = problem.sampling_bounds.T
    for _ in range(2):
        x = (lower + upper) / 2 + reach * generator.uniform(-0.5, 0.5, len(lower)) * (upper - lower)
        x[problem.model.nq :] = 0.0
        found = nearest_equilibrium(problem, Steering(problem).family.straightened(x))
        assert found is not None
        yield found[0]


def judge(problem: PlanningTask, x0: Array, x1: Array, motion: Maneuver, off: float = 1e-5) -> None:
    """The law: it begins at x0, ends at x1 by DOP853, and asks for no more than there is."""
    lower, upper = problem.model.control_bounds.T
    assert ((lower <= motion.u) & (motion.u <= upper)).all()
    assert motion.x.shape == (motion.steps + 1, len(x0))
    assert motion.x[0] == pytest.approx(x0, abs=0)
    matters = ~cyclic_coordinates(problem)
    assert apart(problem, motion.x[-1], x1)[matters].max() < 1e-8
    true = true_states(problem, x0, motion.u)
    assert apart(problem, true[-1], x1)[matters].max() < off
    assert apart(problem, true, motion.x)[:, matters].max() < off


def test_every_machine_with_a_flat_map_is_steered_here() -> None:
    assert {name for name in systems.names() if systems.get(name).flat} == set(FLAT.values())


@pytest.mark.parametrize("machine", FLAT)
@pytest.mark.parametrize("seed", range(4))
def test_a_flat_machine_is_steered_from_any_rest_to_any_other(
    machine: str, seed: int, scenes: Scenes
) -> None:
    problem = scenes(machine)
    x0, x1 = resting(problem, seed, 0.5)
    motion = next(Steering(problem).steer(x0, x1), None)
    assert motion is not None
    judge(problem, x0, x1, motion)
    speeds = motion.x[:, problem.model.nq :]
    bounds = problem.bounds[problem.model.nq :]
    assert (np.abs(speeds) <= 1.02 * bounds[:, 1]).all()  # closing adds little to what was spared


def test_all_ways_of_a_car_end_there(scenes: Scenes) -> None:
    car = scenes("car")
    x0, x1 = np.zeros((2, 7))
    x1[:3] = 8.0, 2.0, 0.5
    motions = list(Steering(car).steer(x0, x1))
    assert len(motions) >= 2
    for motion in motions:
        judge(car, x0, x1, motion)


def test_a_car_straightens_its_wheels_and_turns_them_again(scenes: Scenes) -> None:
    car = scenes("car")
    x0, x1 = np.zeros((2, 7))
    x0[3], x1[:4] = 0.4, (6.0, 1.0, 0.3, -0.2)
    motion = next(Steering(car).steer(x0, x1))
    judge(car, x0, x1, motion)


@pytest.mark.parametrize("seed", range(4))
def test_swinging_loads_are_brought_to_rest(seed: int, scenes: Scenes) -> None:
    cranes, generator = scenes("two_cranes"), np.random.default_rng(seed)
    x1 = cranes.start
    x0 = x1 + 0.3 * cranes.scales * generator.uniform(-1, 1, len(x1))
    motion = next(Steering(cranes).steer(x0, x1), None)
    assert motion is not None
    judge(cranes, x0, x1, motion)


@pytest.mark.parametrize("seed", range(4))
def test_a_pendulum_that_nearly_stands_is_brought_upright(seed: int, scenes: Scenes) -> None:
    """What the integrator errs by grows with exp(w t), by 12000 in three seconds; w^2 = g / l."""
    pendulum, x1 = scenes("pendulum"), np.array([np.pi, 0.0])
    x0 = x1 + np.random.default_rng(seed).uniform(-0.2, 0.2, 2)
    motion = next(Steering(pendulum).steer(x0, x1), None)
    assert motion is not None
    judge(pendulum, x0, x1, motion, off=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_a_submarine_glides_on_to_rest(seed: int, scenes: Scenes) -> None:
    """From a moving state to where it can come to rest: straight ahead, at the same depth."""
    submarine, generator = scenes("submarine"), np.random.default_rng(seed)
    x0, x1 = (submarine.model.rest() for _ in range(2))
    x0[7] = generator.uniform(0.2, 0.6)
    x1[0] = generator.uniform(1.0, 2.0)
    motion = next(Steering(submarine).steer(x0, x1), None)
    assert motion is not None
    judge(submarine, x0, x1, motion)


@pytest.mark.parametrize("machine", ["drive", "coin"])
def test_a_moving_start_and_a_moving_end_are_a_boundary_value_problem(
    machine: str, scenes: Scenes
) -> None:
    problem = scenes(machine)
    x0, x1 = np.zeros((2, problem.model.nx))
    x1[:2] = 1.0, 0.1
    x0[-1] = x1[-1] = 1.0
    if machine == "drive":
        x0[-2] = x1[-2] = 1.0
    motion = next(Steering(problem).steer(x0, x1), None)
    assert motion is not None
    judge(problem, x0, x1, motion)


def test_an_angle_is_reached_the_short_way_round(scenes: Scenes) -> None:
    drive = scenes("drive")
    x0, x1 = np.zeros((2, 7))
    x0[2], x1[2] = 3.0, -3.0
    motion = next(Steering(drive).steer(x0, x1))
    judge(drive, x0, x1, motion)
    assert np.ptp(motion.x[:, 2]) < 0.3


def test_what_is_not_worthwhile_is_not_made(scenes: Scenes) -> None:
    drive, seen = scenes("drive"), []
    x0, x1 = np.zeros((2, 7))
    x1[:3] = 2.0, 1.0, 0.5

    def never(states: Array) -> bool:
        seen.append(states)
        return False

    assert list(Steering(drive).steer(x0, x1, never)) == []
    assert seen
    for states in seen:
        assert states.shape[1] == 7
        assert states[:, 5:] == pytest.approx(0.0)


def test_a_stone_is_not_steered_upward(scenes: Scenes) -> None:
    stone = scenes("stone")
    x1 = stone.start.copy()
    x1[1] = 2.0
    assert list(Steering(stone).steer(stone.start, x1)) == []
