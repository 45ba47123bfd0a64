"""What is left out of a motion: loops, and detours of machines that follow known curves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.concurrency.cancel import never_cancelled
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import resimulate
from kinolab.trajectory import Trajectory
from kinolab.trajopt.exact.segments import Segments
from kinolab.trajopt.nlp.options import SHORT
from kinolab.trajopt.shortening.cycles import cycles_removed
from kinolab.trajopt.shortening.shortcuts import ConnectionGuesses
from tests.trajopt.shortening.test_long_plans import STEP, problem_with

SPEED, TURN = 0.25, 0.25  # [m/s], [rad/s^2]
CIRCLE = round(4 * np.sqrt(np.pi / 2 / TURN) / STEP) // 4 * 4  # steps for a whole turn, about


def segments_of(problem: PlanningTask) -> Segments:
    return Segments(problem, SHORT.segment_clearances[0], never_cancelled)


def looped(problem: PlanningTask) -> Trajectory:
    """Drive straight on with a full circle in the middle, and stop."""
    faster = round(SPEED / 0.25 / STEP)
    turn = 2 * np.pi / (CIRCLE * STEP / 2) ** 2  # so that it is a full one
    straight = [(0.0, 0.0)] * (2 * SHORT.blend_steps)
    circle = [(0.0, turn)] * (CIRCLE // 2) + [(0.0, -turn)] * (CIRCLE // 2)
    ends = [(0.25, 0.0)] * faster, [(-0.25, 0.0)] * faster
    u = np.array([*ends[0], *straight, *circle, *straight, *ends[1]])
    return resimulate(problem, STEP * np.arange(len(u) + 1.0), u)


def test_a_loop_is_left_out_and_what_is_far_from_it_stays(tmp_path: Path) -> None:
    """The circle leads back to its beginning, so that all of its duration may go."""
    problem = problem_with(tmp_path)
    given = looped(problem)
    assert given.x[:, 2].max() == pytest.approx(2 * np.pi, abs=1e-6)
    *_, left = cycles_removed(segments_of(problem), given)
    assert left.duration <= given.duration - 0.9 * CIRCLE * STEP
    assert np.array_equal(left.x[: SHORT.blend_steps], given.x[: SHORT.blend_steps])
    assert np.abs(left.x[:, 2]).max() < np.pi / 2
    motion = resimulate(problem, left.t, left.u)
    nearly = [given.x[-1, 0], given.x[-1, 1]]
    assert motion.x[-1, :2] == pytest.approx(nearly, abs=0.3)  # no piece but the last must hold it


@pytest.mark.parametrize(
    ("name", "dx", "dy", "turn"),
    [("diffdrive_warehouse", 0.2, 2.0, 1.2), ("vehicle_parking", 1.5, 0.6, 0.8)],
)
def test_guesses_between_two_states_roll_and_do_not_slip(
    name: str, dx: float, dy: float, turn: float
) -> None:
    """Wheels let a machine move along its heading only: dx sin(psi) = dy cos(psi)."""
    problem = kinolab.load(name)
    names = problem.model.state_names
    place = [names.index(n) for n in ("x", "y")]
    heading = next(names.index(n) for n in ("psi", "theta") if n in names)
    begin, end = problem.start.copy(), problem.start.copy()
    end[place] += [dx, dy]
    end[heading] += turn
    guesses = list(ConnectionGuesses(problem).between(begin, end, 60))
    assert guesses
    for guess in guesses:
        assert np.array_equal(guess.x[0], begin)
        assert guess.x[-1][[*place, heading]] == pytest.approx(end[[*place, heading]], abs=1e-9)
        moved = np.diff(guess.x[:-1][:, place], axis=0)
        psi = (guess.x[1:-1, heading] + guess.x[:-2, heading]) / 2
        aside = moved[:, 1] * np.cos(psi) - moved[:, 0] * np.sin(psi)
        assert np.abs(aside).max() < 0.1 * np.abs(moved).max()


def test_a_guess_goes_on_at_the_speed_at_which_it_is_entered_and_left() -> None:
    """On a straight line nobody needs to stop: it takes the distance over that speed at most."""
    problem = kinolab.load("diffdrive_warehouse")
    names, distance, speed = problem.model.state_names, 1.5, 0.6  # [m], [m/s]
    place = [names.index("x"), names.index("y")]
    wheels = [names.index("phi_l_dot"), names.index("phi_r_dot")]
    begin = problem.start.copy()
    begin[names.index("psi")] = np.pi / 2
    end = begin.copy()
    end[names.index("y")] += distance
    guesses = ConnectionGuesses(problem)
    standing = next(guesses.between(begin, end, 60))
    begin[wheels] = end[wheels] = speed / problem.system.parameter_values["r"]
    moving = next(guesses.between(begin, end, 60))
    assert moving.duration <= distance / speed < standing.duration
    gone = np.linalg.norm(np.diff(moving.x[:, place], axis=0), axis=1)
    assert gone.min() >= 0.95 * speed * moving.h
    assert gone.sum() == pytest.approx(distance, rel=1e-6)


def test_nothing_is_guessed_through_a_rack() -> None:
    """The first rack of the warehouse stands between x = 2.2 and 3.2."""
    problem = kinolab.load("diffdrive_warehouse")
    begin, end = problem.start.copy(), problem.start.copy()
    begin[:3], end[:3] = (1.2, 1.5, 0.0), (3.8, 1.5, 0.0)
    assert list(ConnectionGuesses(problem).between(begin, end, 40)) == []


def test_a_motion_that_is_one_loop_has_nothing_to_be_spliced(tmp_path: Path) -> None:
    """It ends where it begins, in a last step that is longer: no step is left without the loop."""
    problem = problem_with(tmp_path)
    half = CIRCLE // 2
    turn = 2 * np.pi / (half * STEP) ** 2
    times = STEP * np.append(np.arange(2 * half + 1.0), 2 * half + 6.0)
    u = np.array([(0.0, turn)] * half + [(0.0, -turn)] * half + [(0.0, 0.0)])
    given = resimulate(problem, times, u)
    assert list(cycles_removed(segments_of(problem), given)) == []
