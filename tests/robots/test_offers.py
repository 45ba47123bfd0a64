"""Masses, inertias and friction of robots from files as parameters."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinolab.analyze.execute.conditions import Conditions
from kinolab.analyze.execute.execution import Executor
from kinolab.analyze.execute.execution_report import varied_text
from kinolab.dynamics import Model, System
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.errors import InputError
from kinolab.loading.build import build_problem
from kinolab.loading.find import find_system
from kinolab.robots import read_mjcf, read_urdf
from kinolab.scenario import scenario_from
from kinolab.trajectory import Trajectory

mujoco: Any = pytest.importorskip("mujoco")

G, L = 9.81, 0.5  # [m/s^2], [m]
ARM = """<robot name="arm"><link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 -{L}"/><mass value="2"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="tool"/>
  <joint name="hinge" type="continuous"><parent link="base"/><child link="upper"/>
    <axis xyz="0 1 0"/><limit effort="5" velocity="9"/><dynamics damping="0.3"/></joint>
  <joint name="flange" type="fixed"><parent link="upper"/><child link="tool"/>
    <origin xyz="0 0 -{L}"/></joint></robot>
""".replace("{L}", str(L))
MJCF = """<mujoco><option gravity="0 0 -9.81"/><worldbody>
  <body name="a"><joint name="p" axis="0 1 0" damping="{d}"/>
    <inertial pos="0.1 0 -{c}" mass="{m}" fullinertia="{i} {i} 0.02 0.001 0 0"/>
    <body name="b" pos="0 0 -0.6"><joint name="q" axis="0.6 0.8 0" frictionloss="0"/>
      <inertial pos="0 0.05 -0.2" mass="0.7" diaginertia="0.01 0.02 0.015"/></body></body>
  </worldbody></mujoco>
"""
OWN = {"m": 1.5, "c": 0.3, "i": 0.04, "d": 0.2}


@pytest.fixture
def arm(tmp_path: Path) -> System:
    (tmp_path / "arm.urdf").write_text(ARM)
    return read_urdf(tmp_path / "arm.urdf")


def acceleration(system: System, angle: float, rate: float) -> float:
    return float(system.model().f([angle, rate], [0.0])[1])


@pytest.mark.parametrize(
    ("values", "mass", "inertia", "payload", "damping"),
    [
        ({"m_upper": 3.0}, 3.0, 0.1, 0.0, 0.3),
        ({"I_upper": 2.0, "d_hinge": 0.7}, 2.0, 0.2, 0.0, 0.7),
        ({"m_tool": 1.2}, 2.0, 0.1, 1.2, 0.3),
        ({"d_hinge": 0.0}, 2.0, 0.1, 0.0, 0.0),
    ],
)
def test_a_pendulum_with_other_numbers_falls_as_in_closed_form(
    arm: System,
    values: dict[str, float],
    mass: float,
    inertia: float,
    payload: float,
    damping: float,
) -> None:
    """(m l^2 + I) q'' = -m g l sin q - d q'; a payload hangs where the tool is."""
    angle, rate, arms = 0.7, 1.3, (mass + payload) * L
    expected = (-arms * G * math.sin(angle) - damping * rate) / (arms * L + inertia)
    found = acceleration(arm.with_parameters(**values), angle, rate)
    assert found == pytest.approx(expected, rel=1e-12)


def test_dry_friction_that_a_file_has_not_is_a_parameter_too(arm: System) -> None:
    """Far beyond its smoothing of 0.01 rad/s it is constant."""
    slowed = acceleration(arm.with_parameters(f_hinge=0.6), 0.0, 2.0)
    moment = 2.0 * L * L + 0.1
    assert slowed - acceleration(arm, 0.0, 2.0) == pytest.approx(-0.6 / moment, rel=1e-12)


def test_a_centre_of_mass_that_moves_turns_the_equilibrium(arm: System) -> None:
    """It hangs below the hinge: at rest at atan2(x, l)."""
    moved = arm.with_parameters(cx_upper=0.2)
    assert acceleration(moved, math.atan2(0.2, L), 0.0) == pytest.approx(0.0, abs=1e-12)


def test_what_is_not_changed_costs_nothing(arm: System) -> None:
    """The same value leaves the machine as it is: not one operation more."""
    assert arm.with_parameters(m_upper=2.0, d_hinge=0.3) == arm
    assert not arm.parameters
    assert arm.model().key == arm.with_parameters(m_tool=0.0).model().key


@pytest.mark.parametrize(
    ("names", "changed"),
    [
        ({"m_a": 2.5}, {"m": 2.5}),
        ({"I_a": 2.0}, {"i": 0.08}),
        ({"cz_a": -0.1, "d_p": 0.9}, {"c": 0.1, "d": 0.9}),
    ],
)
def test_a_changed_mjcf_robot_is_the_robot_of_the_changed_file(
    tmp_path: Path, names: dict[str, float], changed: dict[str, float]
) -> None:
    """MuJoCo reads the file with the other numbers; the inertia's other entries are scaled, too."""
    path, text = tmp_path / "two.xml", MJCF
    path.write_text(text.format(**OWN))
    made = read_mjcf(path).with_parameters(**names).model()
    scale = names.get("I_a", 1.0)
    text = text.replace("0.02 0.001", f"{0.02 * scale} {0.001 * scale}")
    there = mujoco.MjModel.from_xml_string(text.format(**OWN | changed))
    data = mujoco.MjData(there)
    for state in np.random.default_rng(1).uniform(-1.0, 1.0, (5, 4)):
        data.qpos[:], data.qvel[:] = np.split(state, 2)
        mujoco.mj_forward(there, data)
        assert made.f(state, [])[2:] == pytest.approx(data.qacc, rel=1e-9, abs=1e-9)


def test_offers_go_through_a_machine_file(arm: System) -> None:
    """A run keeps its machine as text; its executions may vary what the robot's file has."""
    text = machine_to_json(arm)
    again = System.of(machine_from_json(text))
    assert again.offered == arm.offered
    values = {"m_tool": 0.4, "d_hinge": 0.9}
    assert acceleration(again.with_parameters(**values), 0.3, 1.0) == acceleration(
        arm.with_parameters(**values), 0.3, 1.0
    )
    assert System.of(machine_from_json(machine_to_json(arm.with_parameters(**values)))).values


def test_parameters_of_a_model_change_without_deriving_again(arm: System) -> None:
    """What identification does: one model, many values."""
    model = arm.parametric("m_upper", "d_hinge").model()
    assert model.parameter_names == ("d_hinge", "m_upper")
    x = [0.4, 0.8]
    for mass in (1.0, 2.0, 5.0):
        expected = acceleration(arm.with_parameters(m_upper=mass), *x)
        assert model.f(x, [0.0], m_upper=mass)[1] == pytest.approx(expected, rel=1e-12)


def test_conditions_vary_every_number_that_is_not_zero(arm: System) -> None:
    drawn = Conditions(parameters=0.1, built={"m_tool": 0.5}).machine(arm, np.random.default_rng(0))
    found = drawn.parameter_values
    assert 0.45 <= found["m_tool"] <= 0.55
    assert found["m_upper"] != 2.0
    assert "f_hinge" not in found  # 0 stays 0
    assert isinstance(Model(drawn), Model)


def test_a_scenario_gives_them_values_and_names_them_where_one_is_wrong(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(ARM)
    table = {"schema": 1, "title": "An arm", "goal": {"hinge": 1.0}}
    machine = {"file": "arm.urdf", "parameters": {"m_tool": 0.4, "d_hinge": 0.3}}
    found = find_system(scenario_from(table | {"system": machine}, tmp_path / "s.toml"))
    assert found.parameter_values == {"m_tool": 0.4}  # the other one is as in the file


def test_an_unknown_name_is_answered_with_those_that_there_are(arm: System) -> None:
    with pytest.raises(InputError, match=r"'m_uper'\. Did you mean 'm_upper'"):
        arm.with_parameters(m_uper=1.0)
    with pytest.raises(InputError, match="no parameter is called 'mass'"):
        arm.parametric("mass")


def test_masses_that_no_body_has_are_refused(arm: System) -> None:
    with pytest.raises(InputError, match="its mass is -1 kg"):
        arm.with_parameters(m_upper=-1.0)
    with pytest.raises(InputError, match="no rigid body has the principal moments"):
        arm.with_parameters(I_upper=-1.0)
    with pytest.raises(InputError, match="its coefficient is -2"):
        arm.with_parameters(d_hinge=-2.0)


def test_links_and_joints_of_names_that_clash_keep_parameters_apart(tmp_path: Path) -> None:
    """A joint called m_upper is a coordinate, and 'up per' and 'up_per' are one name."""
    text = ARM.replace('"hinge"', '"m_upper"').replace('"tool"', '"up per"')
    (tmp_path / "arm.urdf").write_text(text.replace('"base"', '"up_per"'))
    found = read_urdf(tmp_path / "arm.urdf")
    assert {"m_upper_2", "m_up_per", "d_m_upper"} <= {*found.offered}
    assert found.with_parameters(m_upper_2=4.0).model().parameter_names == ("m_upper_2",)


def test_an_execution_varies_the_numbers_of_a_robots_file(tmp_path: Path) -> None:
    """The plan is for the file's numbers, what carries it out has others and a load."""
    (tmp_path / "arm.urdf").write_text(ARM)
    task = {"schema": 1, "title": "An arm", "system": {"file": "arm.urdf"}, "goal": {"hinge": 0.3}}
    (tmp_path / "task.toml").write_text("")
    problem = build_problem(scenario_from(task, tmp_path / "task.toml"))
    t = np.linspace(0.0, 0.5, 6)
    plan = Trajectory(t, np.zeros((6, 2)), np.zeros((5, 1)), ("hinge", "hinge_dot"), ("torque",))
    conditions = Conditions(parameters=0.1, built={"m_tool": 0.5}, tracked=False)
    executor = Executor(problem, plan, conditions, seed=1)
    run = executor.run(0)
    assert run.parameters["m_upper"] != 2.0
    assert abs(run.parameters["m_tool"] / 0.5 - 1.0) <= 0.1
    assert run.x[-1] == pytest.approx([0.0, 0.0], abs=1e-12)  # it hangs at rest all the same
    assert "m_upper" in varied_text(problem, conditions)
    planned = executor.under(Conditions(tracked=False)).run(0).parameters
    assert (planned["m_upper"], planned["m_tool"]) == (2.0, 0.0)  # as the file says again
