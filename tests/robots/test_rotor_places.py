"""A rotor is an inertia and no body: no workspace limits where it is."""

from __future__ import annotations

from pathlib import Path

import pytest

from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.loading import build_problem, find_scenario
from tests.support import needs

SLIDE = '<joint name="j" type="slide" axis="1 0 0" range="-1 1" armature="0.5"/>'
HINGE = '<joint name="j" axis="0 0 1" range="-1 1" armature="0.5"/>'
BALL = '<joint name="j" type="ball" armature="0.5"/>'
ROBOT = """
<mujoco><worldbody><body pos="5 2 3">{joint}<geom type="box" size=".1 .1 .1" mass="2"/></body>
</worldbody>{motor}</mujoco>"""
SCENARIO = """
schema = 1
title = "A box that a joint moves"
[system]
file = "robot.xml"
[world]
bounds = {{ x = [{low}, 7], y = [1, 3], z = [2.5, 3.5] }}
[bounds]
{rates}
[start]
[goal]
tolerance = {{ }}
"""


@needs("mujoco")
@pytest.mark.parametrize(
    ("joint", "rates"),
    [(SLIDE, ["j_dot"]), (HINGE, ["j_dot"]), (BALL, ["j_wx", "j_wy", "j_wz"])],
)
def test_the_workspace_holds_the_box_and_not_its_rotor(
    joint: str, rates: list[str], tmp_path: Path
) -> None:
    """The box is at (5, 2, 3); the rotor's frame would be at the world's origin."""
    limits = "\n".join(f"{rate} = [-9, 9]" for rate in rates)
    motor = '<actuator><motor joint="j" ctrlrange="-1 1"/></actuator>' if joint != BALL else ""
    (tmp_path / "robot.xml").write_text(ROBOT.format(joint=joint, motor=motor))
    for low, found in ((4.0, set()), (5.5, {"x of body_2", "x of body_2 mass"})):
        (tmp_path / "scenario.toml").write_text(SCENARIO.format(low=low, rates=limits))
        scenario = find_scenario(str(tmp_path / "scenario.toml"))
        problem = build_problem(scenario, planning=False)  # the ball has no motor
        names = {name for name, *_ in problem.limit_violations(problem.start)}
        assert names == found
        kept = machine_from_json(machine_to_json(problem.system))
        assert [body.located for body in kept.bodies].count(False) >= 1
