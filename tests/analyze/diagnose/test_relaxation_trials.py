"""The one change that makes a search succeed, on scenarios where mechanics say which one it is."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

import kinolab
from kinolab import planners
from kinolab.analyze.diagnose import diagnose
from kinolab.analyze.diagnose.relaxation_trials import (
    RelaxationTrial,
    relaxation_trials,
    trial_sentences,
)
from kinolab.analyze.diagnose.relaxations import relaxations
from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner, Budget, Outcome, SearchResult, setting
from kinolab.simulation import Propagator
from tests.analyze.diagnose.scenarios import PENDULUM, ring
from tests.support import OPEN, problem_of

PLENTY = 60.0  # [s]: every search ends by its iterations


@dataclass(frozen=True, kw_only=True)
class Shove(AbstractPlanner):
    """One step of full drive, then the coin rolls on; stops where a step is refused."""

    name: ClassVar[str] = "shove"
    max_steps: int = setting(100, 1)

    def solve(self, problem: PlanningTask, seed: int, budget: Budget) -> SearchResult:  # noqa: ARG002
        """Roll straight ahead."""
        propagator, x, held = Propagator(problem), problem.start.tolist(), list[list[float]]()
        while len(held) < self.max_steps and problem.goal_excess(np.array(x)) > 1.0:
            budget.spent()
            u = [0.0 if held else float(problem.model.control_bounds[0, 1]), 0.0]
            x, free = propagator.step(x, u, problem.step)
            if not free:
                break
            held.append(u)
        inside = problem.goal_excess(np.array(x)) <= 1.0
        outcome = Outcome.SOLVED if inside else Outcome.APPROXIMATE
        t = problem.step * np.arange(len(held) + 1)
        return SearchResult(outcome, t, np.array(held).reshape(-1, 2), budget.iterations)


@pytest.fixture
def shove(monkeypatch: pytest.MonkeyPatch) -> None:
    """Register a planner that the diagnosis has never heard of."""
    known = planners.get
    monkeypatch.setattr(planners, "get", lambda name: Shove if name == "shove" else known(name))


def worked(problem: PlanningTask, planner: str, most: int) -> set[str]:
    plan = problem.solve(planner=planner, seed=1, max_iterations=most, time_limit=PLENTY)
    assert plan.status in {"approximate", "not_found"}
    return {retry.change for retry in relaxation_trials(problem, plan, {}, PLENTY) if retry.solved}


def test_a_wall_all_around_the_goal_is_what_stops_the_search(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, ring(1.0), "start.x=-2", "goal.tolerance=0.3")
    assert worked(problem, "rrt", 1000) == {"obstacles"}


def test_a_tolerance_that_ends_before_the_wall_is_too_small(tmp_path: Path) -> None:
    """The goal is behind the wall; three times its tolerance reaches before it."""
    problem = problem_of(tmp_path, ring(1.0), "start.x=-2", "goal.tolerance=0.5")
    assert "tolerance" in worked(problem, "rrt", 1000)


def test_a_motor_too_weak_for_a_swing_is_named(tmp_path: Path) -> None:
    """From rest at 0, with no way to swing back, 5 N m lift m g l = 9.81 N m to 1.06 rad at most:
    there 5 theta = 9.81 (1 - cos theta). Twice the torque lifts it anywhere.
    """
    upright = ["goal.theta=2.4", "goal.tolerance=0.2", "goal.at_rest=false"]
    problem = problem_of(tmp_path, PENDULUM, *upright, "bounds.theta=[-0.05, 3.2]")
    assert worked(problem, "rrt", 600) == {"limits"}


@pytest.mark.usefixtures("shove")
def test_inputs_held_too_shortly_are_named(tmp_path: Path) -> None:
    """One step of 0.05 s gives R h u / (I + m R²) = 0.133 m/s, in 5 s 0.67 m of the 1.6 m."""
    problem = problem_of(tmp_path, OPEN, "goal.x=0.8", "goal.tolerance=0.2")
    assert worked(problem, "shove", 1000) == {"longer controls"}


@pytest.mark.usefixtures("shove")
def test_a_step_too_coarse_for_a_limit_is_named(tmp_path: Path) -> None:
    """In 1 s the drive would spin the coin at 10.7 rad/s, in 0.25 s at 2.7 rad/s: 4 are allowed."""
    coarse = ["integration.step=1.0", "bounds.phi_dot=[-4, 4]", "planner.name='rrt'"]
    problem = problem_of(tmp_path, OPEN, *coarse, "goal.x=3", "goal.tolerance=0.5")
    assert worked(problem, "shove", 1000) == {"step"}


def test_a_retry_makes_no_more_iterations_than_the_search_that_failed(tmp_path: Path) -> None:
    """A search that had none to speak of is not helped by any change."""
    problem = problem_of(tmp_path, OPEN, "goal.x=4", "goal.tolerance=0.01")
    assert worked(problem, "rrt", 1) == set()


def test_without_time_nothing_is_tried(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "goal.x=4", "goal.tolerance=0.01")
    plan = problem.solve(seed=1, max_iterations=10)
    assert relaxation_trials(problem, plan, {}, 0.0) == ()


def test_the_problem_stays_as_it_was(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, ring(1.0), "start.x=-2", "goal.tolerance=0.3")
    before = problem.model.control_bounds.copy(), problem.step, len(problem.world.obstacles)
    plan = problem.solve(seed=1, max_iterations=10)
    relaxation_trials(problem, plan, {}, PLENTY)
    after = problem.model.control_bounds, problem.step, len(problem.world.obstacles)
    assert (before[0] == after[0]).all()
    assert before[1:] == after[1:]


def test_changes_of_settings_are_told_as_options_to_type(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "integration.step=0.04")
    planner = planners.get("rrt")(max_steps=20)
    words = {change.name: change.words for change in relaxations(problem, planner)}
    assert words["longer controls"] == "with --set planner.max_steps=60 instead of 20"
    assert words["step"] == (
        "with --set integration.step=0.01 instead of 0.04 (and --set planner.min_steps=4 "
        "--set planner.max_steps=80, so that controls last as long)"
    )


def test_the_words_name_what_worked() -> None:
    def tried(*worked: bool) -> list[RelaxationTrial]:
        words = ["without the obstacles", "with 3 times the goal's tolerances"]
        names = ["obstacles", "tolerance"]
        found = zip(names, words, worked, strict=True)
        return [RelaxationTrial(name, text, hit, 0.1) for name, text, hit in found]

    assert list(trial_sentences(tried(True, False))) == [
        "Without the obstacles a plan is found, so they are what is in the way."
    ]
    assert list(trial_sentences(tried(False, True))) == [
        "One change makes it work: a search with 3 times the goal's tolerances finds a plan."
    ]
    assert list(trial_sentences(tried(True, True))) == [
        "Each of these alone makes it work: a search without the obstacles, with 3 times the "
        "goal's tolerances."
    ]
    assert list(trial_sentences(tried(False, False))) == [
        "No single change made a search of 2 s succeed: without the obstacles, with 3 times the "
        "goal's tolerances."
    ]
    assert list(trial_sentences([])) == []


@pytest.mark.search
def test_what_moves_is_named_and_left_out() -> None:
    """A wall as wide as the world runs over the robot; a box stands beside its way."""
    wall = {"name": "wall", "box": [1.0, 4.0, 0.5], "position": [8.0, 2.0, 0.25],
            "motion": {"velocity": [-0.9, 0.0, 0.0]}}  # fmt: skip
    problem = kinolab.load({
        "system": {"name": "diff_drive"},
        "world": {"bounds": {"x": [0, 6], "y": [0, 4]}, "ground": "plane", "obstacle": [
            wall, {"name": "box", "box": [0.2, 0.2, 0.2], "position": [3.0, 3.5, 0.1]}]},
        "start": {"x": 1.0, "y": 2.0},
        "goal": {"x": 5.0, "y": 2.0},
    })  # fmt: skip
    changes = {one.name: one for one in relaxations(problem, Shove())}
    assert changes["obstacles"].words == "without the obstacles that stand"
    moving = changes["moving obstacles"]
    assert moving.words == "without wall, which moves,"
    assert "time" not in moving.problem.model.state_names
    plan = problem.solve(planner="auto", seed=1, max_iterations=3000, time_limit=PLENTY)
    assert plan.status != "solved"
    told = diagnose(problem, plan, max_iterations=3000).sentences
    assert (
        "Its dynamics and what moves (wall) aside, there is a way from the start to the goal."
        in told
    )
    assert any("a search without wall, which moves, finds a plan" in one for one in told)
