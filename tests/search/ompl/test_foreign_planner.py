"""A planner that is not kinolab's grows its own tree on what a problem offers OMPL."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from ompl import base as ob
from ompl import control as oc

import kinolab
from kinolab.errors import InputError
from kinolab.problem import PlanningTask
from kinolab.search.ompl import OmplSetup
from tests.support import coin_after, coin_motion


@dataclass
class Node:
    """A state of OMPL's that was allocated here, and how it was reached."""

    state: Any
    parent: Node | None = None
    control: Any = None
    steps: int = 0


class RandomTree(ob.Planner):  # type: ignore[misc]
    """Grows from any of its states, under any input: the least that a control planner may do."""

    def __init__(self, bridge: OmplSetup) -> None:
        super().__init__(bridge.space_information, "random tree")
        self._information, self._generator = bridge.space_information, np.random.default_rng(1)
        self._limits = bridge.problem.model.control_bounds.T
        self._start = self._information.allocState()  # getStartState would give its own away
        bridge.write(self._start, bridge.problem.start.tolist())

    def setup(self) -> None:
        """Do nothing."""

    def clear(self) -> None:
        """Do nothing: every search has a tree of its own."""

    def solve(self, ended: Callable[[], bool]) -> Any:
        """Search until the goal is reached or the condition says so."""
        definition, information = self.getProblemDefinition(), self._information
        tree = [Node(self._start)]
        while not ended():
            node = self._grown(tree[int(self._generator.integers(len(tree)))])
            if node.steps >= information.getMinControlDuration():
                tree.append(node)
                if definition.getGoal().isSatisfied(node.state):
                    definition.addSolutionPath(self._path(node), False, 0.0, self.getName())
                    return ob.PlannerStatus(ob.PlannerStatus.EXACT_SOLUTION)
        return ob.PlannerStatus(ob.PlannerStatus.TIMEOUT)

    def _grown(self, parent: Node) -> Node:
        information = self._information
        control, state = information.getControlSpace().allocControl(), information.allocState()
        for i, value in enumerate(self._generator.uniform(*self._limits)):
            control[i] = float(value)
        longest = int(self._generator.integers(1, information.getMaxControlDuration() + 1))
        steps = information.propagateWhileValid(parent.state, control, longest, state)
        return Node(state, parent, control, steps)

    def _path(self, last: Node) -> Any:
        way, node = [last], last.parent
        while node is not None:
            way.insert(0, node)
            node = node.parent
        path, step = oc.PathControl(self._information), self._information.getPropagationStepSize()
        path.append(way[0].state)
        for node in way[1:]:
            path.append(node.state, node.control, node.steps * step)
        return path


def test_a_planner_that_kinolab_does_not_know_solves_a_problem(table: PlanningTask) -> None:
    """What it found is the coin's motion in closed form, and ends in the goal."""
    bridge = table.to_ompl()
    planner = RandomTree(bridge)
    planner.setProblemDefinition(bridge.problem_definition)
    planner.setup()
    status = planner.solve(ob.timedPlannerTerminationCondition(60.0))
    assert status.getStatus() == ob.PlannerStatus.EXACT_SOLUTION
    path = bridge.problem_definition.getSolutionPath()
    states = np.array([bridge.read(path.getState(k)) for k in range(path.getStateCount())])
    held = [[path.getControl(k)[i] for i in range(2)] for k in range(path.getControlCount())]
    ends = [
        coin_after(x, np.array(u), np.array([duration]))[0]
        for x, u, duration in zip(states, held, path.getControlDurations(), strict=False)
    ]
    off = np.array(ends) - states[1:]
    off[:, 2:4] = (off[:, 2:4] + np.pi) % (2 * np.pi) - np.pi
    assert np.abs(off).max() < 1e-4  # Runge-Kutta's steps of 0.05 s
    assert states[0] == pytest.approx(table.start)
    assert np.abs(states[-1, :2]).max() <= 0.5


@pytest.mark.parametrize("own", [True, False], ids=["OMPL's RRT", "a planner of one's own"])
def test_what_another_planner_found_comes_back_as_a_trajectory(
    own: bool, table: PlanningTask
) -> None:
    """It is the coin's motion in closed form under the path's controls, and it is verified."""
    bridge = table.to_ompl()
    planner = oc.RRT(bridge.space_information) if own else RandomTree(bridge)
    planner.setProblemDefinition(bridge.problem_definition)
    planner.setup()
    planner.solve(ob.timedPlannerTerminationCondition(60.0))
    found = bridge.trajectory()
    assert kinolab.verify(table, found).passed
    path = bridge.problem_definition.getSolutionPath()
    assert found.duration == pytest.approx(sum(path.getControlDurations()))
    same = bridge.trajectory(path)
    assert same.x.tobytes() == found.x.tobytes()
    assert found.x == pytest.approx(coin_motion(table.start.tolist(), found.t, found.u).x, abs=1e-7)


def test_without_a_solution_there_is_no_trajectory(table: PlanningTask) -> None:
    bridge = table.to_ompl()
    with pytest.raises(InputError, match=r"^trajectory: the problem definition has no solution"):
        bridge.trajectory()
    with pytest.raises(InputError, match=r"^trajectory path: it is 'rrt'\. Give a PathControl\."):
        bridge.trajectory("rrt")


def test_the_planner_that_kinolab_does_not_know_can_be_ended(table: PlanningTask) -> None:
    bridge = table.to_ompl()
    planner = RandomTree(bridge)
    planner.setProblemDefinition(bridge.problem_definition)
    status = planner.solve(ob.PlannerTerminationCondition(lambda: True))
    assert status.getStatus() == ob.PlannerStatus.TIMEOUT
    assert not bridge.problem_definition.hasSolution()


SIMPLE = """
import sys
import kinolab
from ompl import control

setup = kinolab.load("rolling_disk_maze").replace(**{"goal.x": 2.0, "goal.y": 2.0}).to_ompl()
simple = control.SimpleSetup(setup.space_information)
simple.setStartState(setup.problem_definition.getStartState(0))
simple.setGoal(setup.problem_definition.getGoal())
simple.setPlanner(getattr(control, sys.argv[1])(setup.space_information))
simple.solve(60.0)
found = setup.trajectory(simple.getSolutionPath())
assert kinolab.verify(setup.problem, found).passed
"""


@pytest.mark.parametrize("planner", ["RRT", "EST", "KPIECE1"])
def test_a_planner_of_ompl_solves_the_maze_by_simple_setup_and_leaves_in_peace(
    planner: str,
) -> None:
    """Python used to crash when it ended: the start was freed by OMPL and by its binding."""
    command = [sys.executable, "-c", SIMPLE, planner]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("planner", ["SST", "PDST"])
def test_what_the_pages_say_that_python_cannot_construct_it_cannot(planner: str) -> None:
    setup = kinolab.load("rolling_disk_maze").to_ompl()
    with pytest.raises(TypeError, match="no constructor"):
        getattr(oc, planner)(setup.space_information)


def test_the_start_can_be_looked_at_as_often_as_one_likes() -> None:
    setup = kinolab.load("rolling_disk_maze").to_ompl()
    seen = [setup.read(setup.problem_definition.getStartState(0)) for _ in range(3)]
    assert seen == [pytest.approx(setup.problem.start.tolist())] * 3
    with pytest.raises(IndexError):
        setup.problem_definition.getStartState(1)
