"""Inputs that are held for several steps make an exact motion of single steps."""

from __future__ import annotations

import numpy as np
import pytest

import kinolab
from kinolab.problem import PlanningTask
from kinolab.simulation.machine import states_under
from kinolab.trajopt.nlp.decision import Knots
from kinolab.trajopt.nlp.options import SQP
from kinolab.trajopt.nlp.problem import TrajectoryProblem
from kinolab.trajopt.sqp.restoration import coarse_to_fine
from tests.scenario.dynobench.wheel import environment, needs_wheel

EXACT = 1e-6  # sum of all that is missing, in scales


def straight(problem: PlanningTask, steps: int) -> Knots:
    """Return states on the line to the goal, under inputs in the middle of their ranges."""
    end = problem.start.copy()
    end[list(problem.goal.indices)] = problem.goal.targets
    middle = problem.model.control_bounds.mean(axis=1)
    return Knots(np.linspace(problem.start, end, steps + 1), np.tile(middle, (steps, 1)),
                 problem.step)  # fmt: skip


def never() -> bool:
    return False


@pytest.fixture(scope="module")
def task() -> TrajectoryProblem:
    return TrajectoryProblem(kinolab.load(environment("quad2d_v0/empty_0")), 1e-2)


@needs_wheel
def test_a_guess_becomes_a_motion_of_the_machine_in_as_many_steps(task: TrajectoryProblem) -> None:
    guess = straight(task.problem, 240)
    assert sum(task.transcription(guess).violation(guess)) > SQP.coarse_violation
    knots = coarse_to_fine(task, guess)
    assert (len(knots.u), knots.h) == (240, guess.h)
    assert np.array_equal(knots.u[::4], knots.u[3::4])
    assert sum(task.transcription(knots).violation(knots)) < EXACT
    motion = states_under(task.problem, knots.u)
    assert np.allclose(motion[-1], knots.x[-1], rtol=0, atol=EXACT)


@needs_wheel
@pytest.mark.parametrize("steps", [97, 241])
def test_too_few_steps_and_those_that_cannot_be_shared_out_stay(
    task: TrajectoryProblem, steps: int
) -> None:
    guess = straight(task.problem, steps)
    assert coarse_to_fine(task, guess) is guess
