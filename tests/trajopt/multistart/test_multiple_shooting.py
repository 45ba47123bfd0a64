"""From guesses that break everything to motions that end exactly in the goal and pass."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.concurrency.cancel import CancelledError, never_cancelled
from kinolab.numerics.work import counted_work
from kinolab.problem import PlanningTask
from kinolab.solve.plan import CENTRE_TOLERANCE
from kinolab.trajectory import Trajectory
from kinolab.trajopt import shorten
from kinolab.trajopt.multistart.multiple_shooting import Multistart
from tests.support import problem_of
from tests.trajopt.scenarios import DISCRETE, FLY
from tests.trajopt.test_trajopt import DRIVE, EXACT, PATIENCE, repaired

KNOTS, GUESSES = 80, 60


def shot(problem: PlanningTask, seed: int = 2) -> Trajectory:
    """Return the first motion that comes of a guess."""
    shots = Multistart(problem, KNOTS, seed, never_cancelled)
    motions = (shots.next() for _ in range(GUESSES))
    return next(motion for motion in motions if motion is not None)


def passes(problem: PlanningTask, motion: Trajectory) -> bool:
    certificate = kinolab.verify(problem, motion)
    assert certificate.passed, [str(check) for check in certificate.failures]
    return True


@pytest.fixture(scope="module", params=DISCRETE, ids=["fly", "swing up"])
def shown(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[PlanningTask, Trajectory]:
    """A machine that flies or swings, and a motion of it."""
    problem = problem_of(tmp_path_factory.mktemp("discrete"), request.param)
    return problem, shot(problem)


def test_what_swings_and_flies_ends_in_the_middle_of_the_goal(
    shown: tuple[PlanningTask, Trajectory],
) -> None:
    problem, motion = shown
    assert np.array_equal(motion.x[0], problem.start)
    assert problem.goal_distance(motion.x[-1]) < EXACT
    assert passes(problem, motion)


def test_steps_are_those_of_the_problem(shown: tuple[PlanningTask, Trajectory]) -> None:
    problem, motion = shown
    assert np.allclose(np.diff(motion.t), problem.step, rtol=0, atol=1e-12)


def test_equal_seeds_give_the_same_bits(shown: tuple[PlanningTask, Trajectory]) -> None:
    problem, motion = shown
    again = shot(problem)
    assert again.x.tobytes() == motion.x.tobytes()
    assert again.u.tobytes() == motion.u.tobytes()


def test_a_continuous_machine_swings_up_in_steps_of_the_problem() -> None:
    """Its steps are not the true motion, so that it ends only near the middle of the goal."""
    problem = kinolab.load("pendulum_swingup")
    motion = shot(problem)
    assert np.allclose(np.diff(motion.t), problem.step, rtol=0, atol=1e-12)
    assert np.array_equal(motion.x[0], problem.start)
    assert problem.goal_distance(motion.x[-1]) < CENTRE_TOLERANCE
    assert passes(problem, motion)


def test_other_seeds_give_other_motions(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, FLY)
    assert len({shot(problem, seed).u.tobytes() for seed in (1, 2, 3)}) == 3


def test_preparing_changes_nothing(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, FLY)
    prepared = Multistart(problem, KNOTS, 2, never_cancelled)
    prepared.prepare()
    motion = prepared.next()
    assert motion is not None
    assert motion.u.tobytes() == shot(problem, 2).u.tobytes()


def test_preparing_is_charged_alike_however_often_a_problem_is_searched(tmp_path: Path) -> None:
    """So that the same seed gets as far in the first search of a process as in later ones."""
    problem, charged = problem_of(tmp_path, FLY), []
    for seed in (1, 2, 3):
        with counted_work() as work:
            Multistart(problem, KNOTS, seed, never_cancelled).prepare()
        charged.append(work.seconds)
    assert charged[0] > 0
    assert charged == charged[:1] * 3


def test_it_is_too_late_for_ways_when_it_is_stopped(tmp_path: Path) -> None:
    """Where a wall is in the way, a way around it is looked for."""
    wall = "\n[[world.obstacle]]\nbox = [2, 0.1, 1]\nposition = [0, 0.5, 0]\n"
    problem = problem_of(tmp_path, FLY + wall)
    with pytest.raises(CancelledError):
        Multistart(problem, KNOTS, 1, lambda: True).next()


@pytest.mark.parametrize("times", [2, 10])
def test_a_straight_drive_gets_as_short_as_it_can_be_however_long_it_was(
    times: int, tmp_path: Path
) -> None:
    """A double integrator over d with |a| <= A takes 2 sqrt(d / A), here 3.58 s."""
    problem = problem_of(tmp_path, DRIVE)
    shortest = 2 * np.sqrt(0.8 / 0.25)
    slow = repaired(problem, int(times * shortest / problem.step))
    fast = shorten(problem, slow, PATIENCE)
    assert passes(problem, fast)
    assert problem.goal_distance(fast.x[-1]) < EXACT
    assert shortest - problem.step <= fast.duration <= 1.02 * shortest
