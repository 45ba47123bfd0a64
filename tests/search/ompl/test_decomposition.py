"""Syclop's regions, against boxes worked out by hand."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
import pytest
from ompl import base as ob
from ompl import control as oc
from ompl import util as ou

import kinolab
from kinolab.problem import PlanningTask
from kinolab.search.ompl import OmplSetup
from kinolab.search.ompl.decomposition import FREE_VOLUME_DRAWS, Decomposition
from kinolab.search.ompl.regions import Regions

ZOOM = 10.0
CELLS = 10  # the third root of 1000 regions


@pytest.fixture(scope="module")
def parking() -> PlanningTask:
    return kinolab.load("vehicle_parking")


def regions(bridge: OmplSetup) -> Regions:
    return Regions(bridge.problem, 1000, ZOOM, angles=False)


def divided(
    bridge: OmplSetup, looks: int, kind: type[Decomposition] = Decomposition
) -> Decomposition:
    return kind(bridge, regions(bridge), samples=looks, max_states_per_cell=20, seed=1)


def answers(bridge: OmplSetup, looks: int) -> list[tuple[int, bool]]:
    """What OMPL learns where it estimates free volumes: regions, and whether states are free."""
    decomposition = divided(bridge, looks)
    state, sampler = bridge.space.allocState(), bridge.space_information.allocStateSampler()
    found = []
    for _ in range(FREE_VOLUME_DRAWS):
        sampler.sampleUniform(state)
        region = decomposition.locateRegion(state)
        if region >= 0:
            found.append((region, bridge.space_information.isValid(state)))
    return found


def level(problem: PlanningTask, x: np.ndarray) -> int:
    excess = problem.goal_excess(x)
    return 0 if excess > ZOOM else 1 + math.floor(math.log2(ZOOM / max(1.0, excess)))


def test_a_state_lies_in_the_region_of_its_position_and_its_nearness(parking: PlanningTask) -> None:
    bridge, generator = parking.to_ompl(), np.random.default_rng(0)
    decomposition = divided(bridge, 0)
    state = bridge.space.allocState()
    for _ in range(FREE_VOLUME_DRAWS):
        decomposition.locateRegion(state)
    far = generator.uniform(*parking.sampling_bounds.T, (100, 7))
    near = [parking.sample_goal(generator, spread) for spread in generator.uniform(0.5, 12, 100)]
    levels = []
    for x in [*far, *near]:
        bridge.write(state, x.tolist())
        levels.append(level(parking, x))
        cell = int(x[0] / 2.4), int(x[1] / 1.6), levels[-1]
        assert decomposition.locateRegion(state) == cell[0] * 100 + cell[1] * 10 + cell[2]
    assert set(levels) == {0, 1, 2, 3, 4}


def test_free_volumes_are_estimated_from_a_few_states_and_as_many_free_ones(
    parking: PlanningTask,
) -> None:
    """Without any look all that is known is which regions are near the goal and far from it."""
    bridge = parking.to_ompl()
    ou.RNG.setSeed(1)
    none, some = answers(bridge, 0), answers(bridge, 1000)
    assert not any(free for _, free in none)
    assert all(region % CELLS > 0 for region, _ in none)
    assumed, looked = some[: len(none) + 1000], some[len(none) + 1000 :]
    assert sum(free for _, free in assumed) == 1000
    assert {region for region, free in assumed if not free} == {region for region, _ in none}
    assert 900 < len(looked) < 1100
    assert 0 < sum(free for _, free in looked) < len(looked)


def test_the_regions_that_hold_no_state_are_those_far_from_the_goal(parking: PlanningTask) -> None:
    """10 tolerances are 2 m, of regions of 2.4 m by 1.6 m; levels 5 to 9 are beyond the goal."""
    empty = {region for region, _ in answers(parking.to_ompl(), 0)}
    for x in (8.4, 9.9, 13.25, 15.2, 17.0):
        for y in (5.0, 9.0, 12.15, 14.0):
            for near in range(1, CELLS):
                cell = np.array([int(x / 2.4), int(y / 1.6)])
                low, high = cell * [2.4, 1.6], (cell + 1) * [2.4, 1.6]
                reach = 2.0 / 2 ** (near - 1)
                apart = np.maximum(low - [13.25, 12.15], [13.25, 12.15] - high).max()
                region = cell[0] * 100 + cell[1] * 10 + near
                assert (region in empty) is bool(apart > reach or near > 4)


@pytest.mark.parametrize("planner", [oc.SyclopRRT, oc.SyclopEST])
def test_ompl_draws_states_from_the_region_that_it_asks_for(
    planner: Any, parking: PlanningTask
) -> None:
    """The grid moves while OMPL works; the bounds of its regions do not."""
    seen: list[tuple[list[float], np.ndarray]] = []

    class Watched(Decomposition):
        def sampleFullState(self, sampler: Any, coordinates: list[float], state: Any) -> None:
            super().sampleFullState(sampler, coordinates, state)
            seen.append((coordinates, np.array(bridge.read(state))))

    bridge = parking.to_ompl()
    ou.RNG.setSeed(1)
    search = planner(bridge.space_information, divided(bridge, 1000, Watched))
    search.setProblemDefinition(bridge.problem_definition)
    search.setup()
    late = time.monotonic() + (60.0 if planner is oc.SyclopRRT else 1.0)  # SyclopEST draws none
    ended = ob.PlannerTerminationCondition(lambda: len(seen) >= 500 or time.monotonic() > late)
    search.solve(ended)
    assert bool(seen) is (planner is oc.SyclopRRT)
    for coordinates, x in seen:
        assert (np.array(coordinates) >= 0).all()
        assert (np.array(coordinates) <= [24.0, 16.0, CELLS]).all()
        near = int(coordinates[-1])
        if near:
            assert parking.goal_excess(x) <= max(1.0, ZOOM / 2 ** (near - 1)) + 1e-9
        else:
            assert x[:2] == pytest.approx(coordinates[:2])
