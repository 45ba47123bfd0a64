"""Curves between keys are the motion, however fast something turns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinolab.analyze.simulate import simulate
from kinolab.dynamics import Model
from kinolab.loading import build_problem, find_scenario
from kinolab.problem import PlanningTask
from kinolab.show.scene.curves import evaluated
from kinolab.show.scene.keyframes import key_poses
from kinolab.simulation.reference import reference_motion
from kinolab.trajectory import Trajectory
from tests.conftest import Solved
from tests.support import OPEN, problem_of

PROMISED = 1e-4  # [m], and of the entries of rotations


def problem_at(name: str, *overrides: str) -> PlanningTask:
    return build_problem(find_scenario(name, overrides=overrides), planning=False)


def farthest(problem: PlanningTask, trajectory: Trajectory) -> float:
    """The largest difference of any frame, between the curves and DOP853, within the steps."""
    keys = key_poses(problem, trajectory)
    motion = reference_motion(problem, trajectory.x[0], trajectory.t, trajectory.inputs)
    worst = 0.0
    for k in range(len(trajectory.u)):
        at = np.linspace(trajectory.t[k], trajectory.t[k + 1], 9)
        g = problem.model.frames(motion.between(k, at)).reshape(len(at), -1, 3, 4)
        for b, (place, turn) in enumerate(zip(keys.places, keys.turns, strict=True)):
            R = Rotation.from_quat(evaluated(turn, at)).as_matrix()
            worst = max(worst, float(np.abs(R - g[:, b, :, :3]).max()))
            worst = max(worst, float(np.abs(evaluated(place, at) - g[:, b, :, 3]).max()))
    return worst


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("crane", ["start.theta_x=0.5", "start.theta_y=-0.3"]),
        ("diff_drive", ["start.phi_l_dot=9", "start.phi_r_dot=3"]),
        ("satellite", ["start.wheel_x_dot=150", "start.R_wy=0.2", "integration.step=0.5"]),
    ],
)
def test_a_page_shows_the_true_motion_between_knots(name: str, overrides: list[str]) -> None:
    """The satellite's wheel turns twelve times between two knots."""
    problem = problem_at(name, *overrides)
    assert farthest(problem, simulate(problem, 2.0)) < PROMISED


def test_a_planned_motion_with_inputs_that_jump_is_shown_as_it_is(short: Solved) -> None:
    assert farthest(short.problem, short.trajectory) < PROMISED


def test_only_what_turns_fast_gets_more_keys_than_knots() -> None:
    problem = problem_at("satellite", "start.wheel_x_dot=150", "integration.step=0.5")
    trajectory = simulate(problem, 2.0)
    keys, names = key_poses(problem, trajectory), [body.name for body in problem.bodies]
    counts = dict(zip(names, [len(turn.times) for turn in keys.turns], strict=True))
    assert counts["x wheel"] > 50 > counts["bus"]
    assert len(keys.places[0].times) == len(trajectory.t)


def test_the_ends_of_cables_go_along(short: Solved) -> None:
    assert key_poses(short.problem, short.trajectory).ends is None
    problem = problem_at("crane", "start.theta_x=0.5")
    trajectory = simulate(problem, 1.0)
    ends = key_poses(problem, trajectory).ends
    assert ends is not None
    at = trajectory.t[3]
    expected = problem.model.cables(trajectory.x[3]).reshape(-1)
    assert evaluated(ends, np.array([at]))[0] == pytest.approx(expected, abs=1e-12)


def test_a_map_without_time_between_is_joined_by_straight_ways(tmp_path: Path) -> None:
    """What is true of a discrete problem is its map: halfway lies the middle of two knots."""
    discrete = ('integration.truth="discrete"', 'integration.method="euler"')
    problem = problem_of(tmp_path, OPEN, *discrete, "start.psi_dot=1", "start.phi_dot=2")
    trajectory = simulate(problem, 0.5)
    place = key_poses(problem, trajectory).places[0]
    half = 0.5 * (trajectory.t[2] + trajectory.t[3])
    middle = 0.5 * (trajectory.x[2, :2] + trajectory.x[3, :2])
    assert evaluated(place, np.array([half]))[0, :2] == pytest.approx(middle, abs=1e-9)


def test_a_machine_that_has_no_motion_has_one_key(short: Solved) -> None:
    model: Model = short.problem.model
    still = Trajectory(
        np.zeros(1),
        short.problem.start[None],
        np.zeros((0, model.nu)),
        model.state_names,
        model.control_names,
    )
    keys = key_poses(short.problem, still)
    assert [len(curve.times) for curve in (*keys.places, *keys.turns)] == [1, 1]
