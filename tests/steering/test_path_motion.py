"""Motions along paths: limits are kept, and inputs are what inverse dynamics by hand ask for."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from kinolab.problem import PlanningTask
from kinolab.steering import Maneuver, Steering
from kinolab.steering.path_motion import Path
from tests.oracles import crane as newton
from tests.oracles.vehicles import DiffDrive
from tests.scenes import true_states

Scenes = Callable[..., PlanningTask]
Array = np.ndarray

ROBOT = DiffDrive(m=9.0, I_z=0.2, I_w=0.005, r=0.0975, b=0.33, c_w=0.08)
CRANE = newton.Crane(m=1000, M_b=3000, M_t=500, g=9.81, c_x=2500, c_y=1000, c_l=2000, c_s=2000)


def first_motion(problem: PlanningTask, x0: Array, x1: Array) -> Maneuver:
    """The motion along the first way that has one."""
    steering = Steering(problem)
    assert steering.paths is not None
    found = (steering.paths.chain(paths, x0) for paths in steering.family.paths(x0, x1))
    return next(motion for motion in found if motion is not None)


def ahead(distance: float, turn: float = 0.0) -> Array:
    return np.array([distance, 0.2 * distance * np.sign(turn), turn, 0, 0, 0, 0])


@pytest.mark.parametrize("end", [ahead(3.0), ahead(-2.0), ahead(2.0, 0.6), ahead(0.0, 2.0)])
def test_torques_of_a_robot_are_those_of_newton_and_euler(end: Array, scenes: Scenes) -> None:
    """In the middle of each step: forces by the change of speed, moments by that of the turn."""
    drive = scenes("drive")
    motion = first_motion(drive, np.zeros(7), end)
    twists = np.array([ROBOT.twist(x) for x in motion.x])
    (v, w), (dv, dw) = (
        ((twists[1:] + twists[:-1]) / 2).T,
        (np.diff(twists, axis=0) / drive.step).T,
    )
    along, about = ROBOT.drags
    force, moment = ROBOT.mass * dv + along * v, ROBOT.inertia * dw + about * w
    right = ROBOT.r * (force / 2 + moment / ROBOT.b)
    left = ROBOT.r * (force / 2 - moment / ROBOT.b)
    assert motion.u == pytest.approx(np.column_stack([left, right]), abs=6e-3)  # 1 % of 0.6 N m


def test_forces_of_a_crane_are_those_of_newton(scenes: Scenes) -> None:
    """The little friction of swaying is not in the flat map: accelerations agree to that."""
    crane = scenes("crane")
    x0, x1 = np.zeros((2, 10))
    x0[:3], x1[:3] = (4, 4, 6), (14, 9, 4)
    motion = first_motion(crane, x0, x1)
    middle = (motion.x[1:] + motion.x[:-1]) / 2
    wanted = np.diff(motion.x[:, 5:], axis=0) / crane.step
    given = np.array(
        [newton.accelerations(x, u, CRANE) for x, u in zip(middle, motion.u, strict=True)]
    )
    assert np.abs(wanted[:, :2]).max() > 0.1  # [m/s^2]: something moves
    assert given[:, :3] == pytest.approx(wanted[:, :3], abs=0.02)
    assert given[:, 3:] == pytest.approx(wanted[:, 3:], abs=0.01)


@pytest.mark.parametrize(
    ("machine", "end"),
    [
        ("drive", ahead(3.0, 1.0)),
        ("drive", ahead(-4.0)),
        ("drive", np.array([2.0, 0, -2.23581, 0, 0, 0, 0])),
        ("car", ahead(9.0, 1.2)),
        ("car", ahead(-3.0, 0.1)),
        ("coin", np.array([3.0, 1.0, 1.5, 0, 0, 0])),
        ("crane", np.array([12.0, 8, 3, 0, 0, 0, 0, 0, 0, 0])),
    ],
)
def test_a_motion_keeps_all_limits_and_rests_at_both_ends(
    machine: str, end: Array, scenes: Scenes
) -> None:
    problem = scenes(machine)
    x0 = problem.start.copy() if machine == "crane" else np.zeros(len(end))
    motion = first_motion(problem, x0, end)
    lower, upper = problem.model.control_bounds.T
    assert ((lower <= motion.u) & (motion.u <= upper)).all()
    for x in motion.x:
        assert not list(problem.limit_violations(x))
    assert motion.x[[0, -1], problem.model.nq :] == pytest.approx(0.0, abs=1e-12)
    if problem.system.requirements:
        assert (problem.model.requirements(motion.x[:-1], motion.u) > 0).all()


@pytest.mark.parametrize("machine", ["drive", "coin", "car"])
def test_states_along_a_motion_obey_the_constraints(machine: str, scenes: Scenes) -> None:
    """What the places say of the speeds: differences against the machine's own rates."""
    problem = scenes(machine)
    end = np.zeros(problem.model.nx)
    end[:3] = 3.0, 1.0, 0.8
    motion = first_motion(problem, np.zeros(len(end)), end)
    rates = problem.model.velocity(motion.x)
    moved = (motion.x[2:, : problem.model.nq] - motion.x[:-2, : problem.model.nq]) / 2
    assert moved / problem.step == pytest.approx(rates[1:-1], abs=0.02 * np.abs(rates).max())


def test_inputs_held_for_a_step_hardly_leave_the_path(scenes: Scenes) -> None:
    drive = scenes("drive")
    motion = first_motion(drive, np.zeros(7), ahead(3.0, 1.0))
    reached = true_states(drive, motion.x[0], motion.u)
    assert reached[:, :2] == pytest.approx(motion.x[:, :2], abs=0.05)  # [m]


def test_limits_of_rates_that_are_no_states_are_kept(scenes: Scenes) -> None:
    slow = scenes("drive", "bounds.psi_dot=[-0.3, 0.3]")
    motion = first_motion(slow, np.zeros(7), ahead(2.0, 1.0))
    turning = 0.0975 * (motion.x[:, 6] - motion.x[:, 5]) / 0.33
    assert 0.2 < np.abs(turning).max() <= 0.3


def test_a_robot_that_may_only_go_forward_goes_forward_or_not_at_all(scenes: Scenes) -> None:
    forward = scenes("drive", "bounds.phi_l_dot=[0, 8]", "bounds.phi_r_dot=[0, 8]")
    motion = first_motion(forward, np.zeros(7), ahead(3.0))
    assert motion.x[:, 5:].min() >= 0.0
    steering = Steering(forward)
    assert list(steering.steer(np.zeros(7), ahead(-3.0))) == []
    assert not steering.reversible
    assert Steering(scenes("drive")).reversible


def test_what_asks_for_more_room_than_there_is_has_no_motion(scenes: Scenes) -> None:
    crane = scenes("crane")
    steering = Steering(crane)
    outside = crane.start.copy()
    outside[2] = 8.5  # [m] of rope, of 8.2
    assert steering.paths is not None
    for paths in steering.family.paths(crane.start, outside):
        assert steering.paths.chain(paths, crane.start) is None


def test_a_path_aside_is_no_path_for_wheels(scenes: Scenes) -> None:
    steering = Steering(scenes("drive"))
    assert steering.paths is not None

    def aside(share: Array, _rate: Array, _slope: Array) -> Array:
        return np.column_stack([0 * share, share, 0 * share])

    assert steering.paths.follow(aside, np.zeros(7)) is None


def test_looks_are_at_rest_on_the_path_and_begin_in_its_middle(scenes: Scenes) -> None:
    crane = scenes("crane")
    steering = Steering(crane)
    assert steering.paths is not None
    end = crane.start.copy()
    end[:3] += [4.0, 2.0, -1.0]
    ((path,),) = list(steering.family.paths(crane.start, end))
    states = steering.paths.sample_states(path, crane.start, 5)
    assert states.shape == (5, 10)
    assert states[0] == pytest.approx((crane.start + end) / 2, abs=1e-9)
    assert sorted(states[:, 0]) == pytest.approx(np.linspace(3, 7, 5))
    assert states[:, 3:] == pytest.approx(0.0, abs=1e-12)


def test_stops_are_made_between_the_paths_of_a_chain(scenes: Scenes) -> None:
    drive = scenes("drive")
    steering = Steering(drive)
    assert steering.paths is not None
    end = np.array([0.5, 2.0, 0.0, 0, 0, 0, 0])
    turn_go_turn: list[Path] = list(steering.family.paths(np.zeros(7), end))[-1]
    assert len(turn_go_turn) == 3
    motion = steering.paths.chain(turn_go_turn, np.zeros(7))
    assert motion is not None
    still = np.abs(motion.x[:, 5:]).max(axis=1) < 1e-9
    assert still.sum() == 4
    assert motion.x.shape == (motion.steps + 1, 7)
