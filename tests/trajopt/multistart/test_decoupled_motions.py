"""Motions along decoupling fields: from rest to rest in time, and planned with them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.errors import InputError
from kinolab.problem import PlanningTask
from kinolab.problem.kinematic_task import decoupled_model, is_underactuated
from kinolab.trajopt.multistart.decoupled_multistart import DecoupledMultistart
from kinolab.trajopt.multistart.decoupled_paths import Leg
from kinolab.trajopt.multistart.rest_to_rest import Profile
from tests.oracles.snakeboard import Board, swing

ENOUGH = 300.0  # [s] for a search, so that a busy computer may take longer
PARK = """
schema = 1
title = "A snakeboard parks"
[system]
name = "snakeboard"
[world]
bounds = { x = [-2.0, 3.0], y = [-2.0, 2.0] }
[metric]
theta = 0.5
psi = 0.01
s = 0.0001
phi = 0.2
[start]
[goal]
x = 0.5
y = 0.5
theta = 0.0
at_rest = true
[goal.tolerance]
x = 0.1
y = 0.1
theta = 0.1
s_dot = 1.0
psi_dot = 1.0
phi_dot = 1.0
[integration]
step = 0.05
"""


def park(folder: Path, *overrides: str) -> PlanningTask:
    path = folder / "park.toml"
    path.write_text(PARK)
    return kinolab.load(path, overrides=list(overrides))


@pytest.mark.parametrize("ramp", [0.15, 0.3, 0.5])
def test_a_profile_leads_from_rest_to_rest(ramp: float) -> None:
    """Its derivatives are those of finite differences, and it ends where it should."""
    tau = np.linspace(0.0, 1.0, 4001)
    s, speed, gain = Profile(ramp).at(tau)
    np.testing.assert_allclose([s[0], s[-1], speed[0], speed[-1]], [0, 1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(np.gradient(s, tau)[1:-1], speed[1:-1], atol=1e-4)
    np.testing.assert_allclose(np.gradient(speed, tau)[1:-1], gain[1:-1], atol=0.1)


def test_without_friction_the_board_swings_as_its_momentum_says(tmp_path: Path) -> None:
    """Steer, then turn the rotor: the machine under the inputs ends at rest at the known pose.

    The wheels' spin is left out, as in the oracle. Held inputs miss by O(h^2).
    """
    none = [f"system.parameters.{name}=0.0" for name in ("c_r", "c_psi", "c_phi")]
    problem = park(tmp_path, *none, "system.parameters.I_s=1e-9", "integration.step=0.01")
    multistart = DecoupledMultistart(problem, 1, lambda: False)
    assert decoupled_model(problem).control_names == ("along_psi_rate", "along_phi_rate")
    guess = multistart._guess([Leg(1, 0.6), Leg(0, 9.0)])
    assert guess is not None
    x = guess.x[0]
    for u in guess.u:
        x = problem.model.step(x, u, guess.h)
    pose = swing(np.zeros(3), 0.6, 9.0, Board(c_r=0.0))
    np.testing.assert_allclose(x[:5], [*pose, 9.0, 0.6], atol=2e-3)  # [m, rad]
    assert np.abs(x[6:] / problem.scales[6:]).max() < 2e-3  # at rest


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("drag", [0.0, 0.4])
def test_a_snakeboard_parks(tmp_path: Path, seed: int, drag: float) -> None:
    """With drag, which the fields leave out, the optimisation makes up for it."""
    problem = park(tmp_path, f"system.parameters.c_r={drag}")
    plan = problem.solve(planner="kinematic_first", seed=seed, time_limit=ENOUGH, improve=0.0)
    assert plan.status == "solved"
    assert kinolab.verify(problem, plan.trajectory).passed
    assert problem.goal_distance(plan.trajectory.x[-1]) < 1e-6


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("crane_factory", "gravity or springs push it where no input does"),
        ("submarine_corridor", "gravity or springs push it where no input does"),
    ],
)
def test_what_has_no_decoupling_fields_is_refused(name: str, reason: str) -> None:
    problem = kinolab.load(name)
    assert is_underactuated(problem)
    with pytest.raises(InputError, match=reason) as caught:
        problem.solve(planner="kinematic_first", time_limit=1.0)
    (mistake,) = caught.value.mistakes
    assert mistake.where == f"{name}.toml [planner] name"


def test_a_machine_that_begins_in_motion_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not rest at the start"):
        decoupled_model(park(tmp_path, "start.psi_dot=0.5"))
