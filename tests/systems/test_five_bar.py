"""The parallel robot against plane geometry, Lagrange's equation in two angles, and energy."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import kinolab
from kinolab import systems
from kinolab.runs import check_run, write_run
from kinolab.search.potential.control_points import control_points
from kinolab.simulation.reference import resimulate
from kinolab.verification import verify
from tests.conftest import Solver
from tests.oracles.five_bar import FiveBar

Array = NDArray[np.float64]

ROBOT = FiveBar()
HEAVY = FiveBar(l=0.3, m_u=0.2, m_f=0.4, m_t=0.7)
TOOL = 0  # of the bodies


@pytest.fixture(scope="module")
def model() -> Any:
    return systems.get("five_bar").model()


def postures(count: int, seed: int = 0) -> Array:
    """Motors' angles at which no elbow is straight and the forearms do not line up."""
    return np.random.default_rng(seed).uniform(-0.35, 0.35, (count, 2))


def test_states_and_controls_carry_the_authors_names(model: Any) -> None:
    assert model.state_names == ("a_l", "a_r", "f_l", "f_r", "a_l_dot", "a_r_dot")
    assert model.control_names == ("left_motor", "right_motor")


@pytest.mark.parametrize("length", [0.1, 0.25, 1.0])
def test_home_is_an_equilateral_triangle_on_two_upright_arms(model: Any, length: float) -> None:
    residual = model.constraint_residual(np.zeros(6), l=length)
    assert np.abs(residual).max() < 1e-15  # [m]
    tip = model.frames(np.zeros(6), l=length)[TOOL, [3, 7]]
    assert tip == pytest.approx([0.0, length * (1 + np.sqrt(3) / 2)])


@pytest.mark.parametrize("robot", [ROBOT, HEAVY])
def test_the_tool_is_where_two_circles_meet(model: Any, robot: FiveBar) -> None:
    for a in postures(20):
        x = np.append(robot.angles(a), [0.0, 0.0])
        assert np.abs(model.constraint_residual(x, **asdict(robot))).max() < 1e-14  # [m]
        left, right = robot.elbows(a)
        tip = complex(*model.frames(x, **asdict(robot))[TOOL, [3, 7]])
        assert tip == pytest.approx(robot.tool(a), abs=1e-14)
        assert abs(tip - left) == pytest.approx(robot.l)
        assert abs(tip - right) == pytest.approx(robot.l)


def test_the_forearms_follow_the_motors(model: Any) -> None:
    """Differences of the closed form: a third derivative of about 10 / NUDGE^2."""
    rng = np.random.default_rng(1)
    for a in postures(20):
        rates = rng.uniform(-3, 3, 2)
        x = np.concatenate([ROBOT.angles(a), rates])
        np.testing.assert_allclose(model.velocity(x), ROBOT.slopes(a) @ rates, atol=1e-6)


@pytest.mark.parametrize("robot", [ROBOT, HEAVY])
def test_accelerations_are_those_of_lagranges_equation_in_two_angles(
    model: Any, robot: FiveBar
) -> None:
    rng = np.random.default_rng(2)
    for a in postures(20):
        rates, torques = rng.uniform(-3, 3, 2), rng.uniform(-0.5, 0.5, 2)
        x = np.concatenate([robot.angles(a), rates])
        found = model.f(x, torques, **asdict(robot))[4:]
        expected = robot.accelerations(a, rates, torques)
        np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-5)  # [rad/s^2]


def test_energy_is_kinetic_and_weighs_as_the_oracle_says(model: Any) -> None:
    rng = np.random.default_rng(3)
    level = model.energy(np.zeros(6))[1]
    for a in postures(20):
        rates = rng.uniform(-3, 3, 2)
        kinetic, potential = model.energy(np.concatenate([ROBOT.angles(a), rates]))
        assert kinetic == pytest.approx(rates @ ROBOT.mass_matrix(a) @ rates / 2, rel=1e-6)
        assert potential == pytest.approx(level)  # it moves on one level


def test_what_is_mirrored_moves_as_the_mirror_image(model: Any) -> None:
    """But for the tool, which turns with the left forearm: here it weighs nothing."""
    rng = np.random.default_rng(4)
    swap = [1, 0, 3, 2, 5, 4]
    for a in postures(10):
        x, u = np.concatenate([ROBOT.angles(a), rng.uniform(-3, 3, 2)]), rng.uniform(-0.5, 0.5, 2)
        mirrored = -model.f(-x[swap], -u[::-1], m_t=0.0)[swap]
        np.testing.assert_allclose(mirrored, model.f(x, u, m_t=0.0), rtol=1e-9, atol=1e-9)


def test_left_to_itself_it_keeps_its_energy_and_its_forearms_together() -> None:
    problem = kinolab.load("five_bar_table", overrides=["start.a_l_dot=-0.4", "start.a_r_dot=-0.3"])
    motion = resimulate(problem, np.linspace(0.0, 1.0, 51), np.zeros((50, 2)))
    energies = np.sum(problem.model.energy(motion.x), axis=0)
    assert np.ptp(energies) < 1e-7  # [J]; an integrator accurate to 1e-9 takes dozens of steps
    for x in motion.x:
        assert np.abs(ROBOT.angles(x[:2]) - x[:4]).max() < 1e-11  # [rad]


def test_its_plan_leads_between_wall_and_post_and_is_proved(solved: Solver, tmp_path: Path) -> None:
    found = solved("five_bar_table")
    assert verify(found.problem, found.trajectory).passed
    tips = np.array([ROBOT.tool(x[:2]) for x in found.trajectory.x])
    crossing = tips[:-1][np.diff(np.sign(tips.real)) != 0]
    assert len(crossing) % 2 == 1  # it ends on the other side
    assert ((crossing.imag > 0.15) & (crossing.imag < 0.29)).all()  # [m] between the two
    write_run(tmp_path, found.problem, found.plan)
    assert check_run(tmp_path).passed


def test_what_stands_still_leads_no_potential() -> None:
    """The shoulders and the motors are where they are; the field planner once failed on them."""
    points = control_points(kinolab.load("five_bar_table"))
    assert {point.name for point in points} == {
        "tool",
        "front of left upper arm",
        "front of right upper arm",
        *(f"{end} of {side} forearm" for end in ("front", "back") for side in ("left", "right")),
    }
