"""Guided motions: OMPL keeps what was held, limits last, and no motion passes through the goal."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ompl import base as ob
from ompl import util as ou

import kinolab
from kinolab import planners
from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.search.ompl import AbstractTreePlanner
from kinolab.search.ompl.control_guidance import ControlGuide
from kinolab.search.ompl.goal_region import GoalSamples
from tests.support import OPEN, coin_after, problem_of

GUIDED = ("est", "kpiece", "syclop_est", "syclop_rrt")
STEPS = 15


def grown(name: str, problem: PlanningTask, seconds: float) -> tuple[Any, Any]:
    """A bridge whose problem OMPL's planner has searched, and the planner."""
    settings = planners.get(name)()
    assert isinstance(settings, AbstractTreePlanner)
    bridge = settings.ompl_setup(problem, 1, Budget(math.inf))
    ou.RNG.setSeed(1)
    planner = settings.begin(bridge)
    planner.solve(ob.timedPlannerTerminationCondition(seconds))
    return bridge, planner


def states_of(bridge: Any) -> np.ndarray:
    path = bridge.problem_definition.getSolutionPath()
    return np.array([bridge.read(path.getState(k)) for k in range(path.getStateCount())])


@pytest.mark.parametrize("name", GUIDED)
def test_the_inputs_that_ompl_keeps_are_those_that_were_held(
    name: str, table: PlanningTask
) -> None:
    """The coin's motion in closed form; Runge-Kutta's steps of 0.05 s err by some 1e-6."""
    bridge, _planner = grown(name, table, 5.0)
    path, states = bridge.problem_definition.getSolutionPath(), states_of(bridge)
    held = [[path.getControl(k)[i] for i in range(2)] for k in range(path.getControlCount())]
    assert len(held) == len(states) - 1 > 0
    for x, u, duration, after in zip(
        states, np.array(held), path.getControlDurations(), states[1:], strict=False
    ):
        off = coin_after(x, u, np.array([duration]))[0] - after
        off[2:4] = (off[2:4] + np.pi) % (2 * np.pi) - np.pi
        assert np.abs(off).max() < 1e-4


@pytest.mark.parametrize("name", GUIDED)
def test_a_motion_ends_where_it_enters_the_goal(name: str, table: PlanningTask) -> None:
    found = table.solve(planner=name, seed=3, max_iterations=20_000)
    assert found.status == "solved"
    assert found.trajectory is not None
    excess = [table.goal_excess(x) for x in found.trajectory.x]
    assert excess[-1] <= 1.0
    assert min(excess[:-1]) > 0.99  # OMPL's goal is 0.999 of the tolerance


def guide(problem: PlanningTask, **guidance: Any) -> ControlGuide:
    return ControlGuide(
        problem,
        GoalSamples(problem),
        min_steps=1,
        max_steps=STEPS,
        goal_region_scale=10.0,
        seed=0,
        **guidance,
    )


def led(problem: PlanningTask, x: np.ndarray, u: list[float]) -> np.ndarray:
    """The states that the machine comes to while it holds an input."""
    states = [x]
    for _ in range(STEPS):
        states.append(problem.model.step(states[-1], u, problem.step))
    return np.array(states[1:])


def lasts(problem: PlanningTask, states: np.ndarray) -> int:
    """How many steps keep all limits of the state."""
    low, high = problem.bounds.T
    kept = ((states >= low) & (states <= high)).all(axis=1)
    return STEPS if kept.all() else int(kept.argmin())


def test_an_input_is_held_that_keeps_the_limits_for_longer_than_the_one_drawn() -> None:
    """The snakeboard's rotor and steering reach their limits within a second or so."""
    problem = kinolab.load("snakeboard_park")
    chosen, generator = guide(problem), np.random.default_rng(0)
    gained = 0
    for _ in range(100):
        x = problem.start.copy()
        x[problem.model.nq :] = generator.uniform(*problem.bounds[problem.model.nq :].T)
        drawn = generator.uniform(*problem.model.control_bounds.T).tolist()
        written = [np.nan] * problem.model.nu
        held = chosen.hold(x.tolist(), drawn, written)
        assert written == held
        assert (np.abs(held) <= problem.model.control_bounds[:, 1]).all()
        before, after = (lasts(problem, led(problem, x, u)) for u in (drawn, held))
        assert after >= before
        assert held == drawn or before < STEPS  # what lasts is not changed
        gained += after > before
    assert gained > 30


def test_near_the_goal_an_input_is_held_that_leads_nearer_than_the_one_drawn() -> None:
    problem = kinolab.load("vehicle_parking")
    chosen, generator = guide(problem, goal_bias=1.0), np.random.default_rng(0)
    gained, tried = 0, 0
    for _ in range(100):
        x = problem.sample_goal(generator, 5.0)
        drawn = generator.uniform(*problem.model.control_bounds.T).tolist()
        held = chosen.hold(x.tolist(), drawn, [0.0] * problem.model.nu)
        ways = [led(problem, x, u)[: lasts(problem, led(problem, x, u))] for u in (drawn, held)]
        if all(map(len, ways)):
            before, after = (min(map(problem.goal_excess, way)) for way in ways)
            gained, tried = gained + (after < before), tried + 1
    assert tried > 50
    assert gained > 0.6 * tried  # it aims at states of the goal, of which the best is not known


def test_a_motion_is_over_when_its_steps_are(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "goal.x=4", "goal.tolerance=0.1")
    led_by, x, u = guide(problem), problem.start, [0.01, 0.0]
    for k in range(2 * STEPS):
        assert led_by.hold(x.tolist(), u, [0.0, 0.0]) == u
        assert led_by.ends() is (k == STEPS)
        if k == STEPS:
            led_by.reached(x.tolist(), x.tolist(), free=False)
            break
        after = problem.model.step(x, u, problem.step)
        led_by.reached(x.tolist(), after.tolist(), free=True)
        x = after


def test_what_was_stopped_counts_where_its_motion_began(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "goal.x=4", "goal.tolerance=0.1")
    led_by, first, second = guide(problem), [0.0] * 6, [0.1, *[0.0] * 5]
    led_by.hold(first, [0.1, 0.0], [0.0, 0.0])
    led_by.reached(first, second, free=True)
    assert led_by.counted(second) == second
    led_by.hold(second, [0.1, 0.0], [0.0, 0.0])
    led_by.reached(second, [0.2, *[0.0] * 5], free=False)
    assert led_by.counted(second) == first
    assert led_by.counted([1.0] * 6) == [1.0] * 6


@pytest.mark.parametrize("name", GUIDED)
def test_a_single_input_is_a_choice_too(name: str, table: PlanningTask) -> None:
    found = table.solve(planner=name, seed=1, max_iterations=20_000, control_samples=1)
    assert found.status == "solved"
