"""The biped's oracle against differences, round trips and feet that stay."""

from __future__ import annotations

import numpy as np
import pytest

from tests.oracles.biped import (
    HIP,
    OTHER,
    Array,
    Biped,
    Foot,
    Side,
    double_basis,
    drift,
    foot_jacobian,
    foot_place,
    from_stance,
    leg_points,
    other_foot,
    reach,
    shank_angle,
    stance_basis,
    stance_motion,
    stance_rates,
    stance_rows,
    torso_jump,
    walk,
)

SIDES: tuple[Side, Side] = ("left", "right")
FEET: tuple[Foot, Foot] = ("point", "flat")
ROBOTS = [Biped(), Biped(h=0.2, L_1=0.5, L_2=0.4, sense=-1)]


def random_q(seed: int) -> Array:
    return np.random.default_rng(seed).uniform(-1, 1, 7)


def sway(t: float) -> Array:
    return np.array([0.3 * np.cos(2 * t), np.sin(t), -np.cos(3 * t), 0.5, np.sin(2 * t)])


def test_senses_of_the_angles() -> None:
    q = np.array([0, 1, 0, np.pi / 2, 0, 0, 0])
    assert list(foot_place(q, "left", Biped())) == pytest.approx([0.9, 0.7])  # swung ahead
    assert list(foot_place(q, "left", Biped(sense=-1))) == pytest.approx([-0.9, 0.7])
    assert list(foot_place(q, "right", Biped())) == pytest.approx([0, -0.2])


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("side", SIDES)
def test_jacobian_is_the_derivative(robot: Biped, side: Side) -> None:
    q, h = random_q(1), 1e-6
    columns = [
        (foot_place(q + h * e, side, robot) - foot_place(q - h * e, side, robot)) / (2 * h)
        for e in np.eye(7)
    ]
    assert foot_jacobian(q, side, robot) == pytest.approx(np.array(columns).T, abs=1e-9)


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("foot", FEET)
def test_allowed_velocities_are_all_that_the_rows_allow(
    robot: Biped, side: Side, foot: Foot
) -> None:
    q = random_q(2)
    w, S = stance_rows(q, side, robot, foot), stance_basis(q, side, robot, foot)
    assert np.abs(w @ S).max() < 1e-14
    assert S.shape[1] + np.linalg.matrix_rank(w) == 7
    assert S[7 - S.shape[1] :] == pytest.approx(np.eye(S.shape[1]))  # inputs are rates of q


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("foot", FEET)
def test_pinned_foot_does_not_drift(robot: Biped, side: Side, foot: Foot) -> None:
    q = random_q(3)
    u = sway if foot == "point" else lambda t: sway(t)[1:]
    path = stance_motion(q, u, 2.0, side, robot, foot)
    assert drift(path, side, robot) < 1e-9  # [m]
    assert drift(path, OTHER[side], robot) > 0.1
    if foot == "flat":
        assert shank_angle(path[-1], side) == pytest.approx(shank_angle(q, side), abs=1e-12)


def test_integrated_torso_is_where_the_angles_put_it() -> None:
    q, robot = random_q(4), ROBOTS[1]
    end = stance_motion(q, sway, 2.0, "right", robot)[-1]
    exact = walk(q, [("right", end[2:] - q[2:])], robot)[-1]
    assert end == pytest.approx(exact, abs=1e-9)
    swayed = [0.15 * np.sin(4), 1 - np.cos(2), -np.sin(6) / 3, 1.0, (1 - np.cos(4)) / 2]
    assert end[2:] - q[2:] == pytest.approx(swayed, abs=1e-9)


@pytest.mark.parametrize("robot", ROBOTS)
def test_stances_describe_the_same_configuration(robot: Biped) -> None:
    q = random_q(5)
    for side in SIDES:
        assert from_stance(foot_place(q, side, robot), q[2:], side, robot) == pytest.approx(q)
        there = other_foot(foot_place(q, side, robot), q[2:], side, robot)
        assert other_foot(there, q[2:], OTHER[side], robot) == pytest.approx(
            foot_place(q, side, robot)
        )


@pytest.mark.parametrize("robot", ROBOTS)
def test_torso_loses_the_velocity_of_the_landing_foot(robot: Biped) -> None:
    q, u = random_q(6), sway(0.4)
    landing = foot_jacobian(q, "right", robot) @ stance_rates(q, u, "left", robot)
    assert torso_jump(q, u, robot) == pytest.approx(-landing, abs=1e-14)


@pytest.mark.parametrize("robot", ROBOTS)
def test_double_support_moves_neither_foot(robot: Biped) -> None:
    S = double_basis(random_q(7), robot)
    assert np.abs(S.T @ S - np.eye(3)).max() < 1e-14
    for side in SIDES:
        assert np.abs(foot_jacobian(random_q(7), side, robot) @ S).max() < 1e-14


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("bend", [1, -1])
def test_reach_puts_the_foot_where_it_shall_be(robot: Biped, bend: int) -> None:
    q = np.array([0.3, 1.2, 0.2, 0, 0, 0, 0])
    hip = leg_points(q, "left", robot)[0]
    target = hip + np.array([0.35, -0.6])
    q[HIP["left"] : HIP["left"] + 2] = reach(hip, target, float(q[2]), bend, robot)
    assert foot_place(q, "left", robot) == pytest.approx(target)
    assert np.sign(q[4]) == bend
    with pytest.raises(ValueError, match="from its hip"):
        reach(hip, hip + 2, 0.0, bend, robot)


def test_steps_add_up() -> None:
    """Legs swap twice: each foot is put a step ahead, and the angles return."""
    robot, spread = Biped(), np.array([0, 0.3, 0, -0.3, 0])
    q = from_stance(np.zeros(2), -spread, "right", robot)  # right foot ahead
    there, back = walk(q, [("right", 2 * spread), ("left", -2 * spread)], robot)[1:]
    step = 2 * (robot.L_1 + robot.L_2) * np.sin(0.3)
    assert foot_place(there, "left", robot) == pytest.approx([step, 0], abs=1e-14)
    assert foot_place(back, "right", robot) == pytest.approx([2 * step, 0], abs=1e-14)
    assert back - q == pytest.approx([2 * step, *np.zeros(6)], abs=1e-14)
