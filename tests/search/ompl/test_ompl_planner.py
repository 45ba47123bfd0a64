"""Planners of kinolab are OMPL's planners too."""

from __future__ import annotations

import numpy as np
import pytest
from ompl import base as ob

from kinolab import planners
from kinolab.problem import PlanningTask
from kinolab.search.ompl import OmplPlanner
from tests.support import coin_after

OWN = [name for name in ("potential_field", "prm", "prm_geometric") if name in planners.names()]


SLOW = "potential_field"  # half a minute, for a field in six dimensions


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.long) if n == SLOW else n for n in OWN]
)
def test_ompl_runs_a_planner_of_kinolab(name: str, table: PlanningTask) -> None:
    """The path that OMPL holds is the coin's motion in closed form, and ends in the goal."""
    bridge = table.to_ompl()
    planner = OmplPlanner(bridge, planners.get(name)(), seed=1)
    assert planner.getName() == name
    status = planner.solve(ob.timedPlannerTerminationCondition(60.0))
    assert status.getStatus() == ob.PlannerStatus.EXACT_SOLUTION
    assert bridge.problem_definition.hasExactSolution()
    path = bridge.problem_definition.getSolutionPath()
    states = np.array([bridge.read(path.getState(k)) for k in range(path.getStateCount())])
    held = [[path.getControl(k)[i] for i in range(2)] for k in range(path.getControlCount())]
    for x, u, duration, after in zip(
        states, np.array(held), path.getControlDurations(), states[1:], strict=False
    ):
        off = coin_after(x, u, np.array([duration]))[0] - after
        off[2:4] = (off[2:4] + np.pi) % (2 * np.pi) - np.pi
        assert np.abs(off).max() < 1e-6  # what the re-simulation's tolerance of 1e-9 leaves
    assert np.hypot(*states[-1, :2]) <= 0.5
    assert bridge.space_information.isValid(path.getState(0))


@pytest.mark.parametrize("name", OWN)
def test_ompl_can_end_the_search(name: str, table: PlanningTask) -> None:
    bridge = table.to_ompl()
    planner = OmplPlanner(bridge, planners.get(name)(), seed=1)
    status = planner.solve(ob.PlannerTerminationCondition(lambda: True))
    assert status.getStatus() == ob.PlannerStatus.TIMEOUT
    assert not bridge.problem_definition.hasSolution()
