"""A start at which a constraint does not hold is refused, with the nearest one at which all do."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import kinolab
from kinolab.analyze.simulate import simulate
from kinolab.dynamics import (
    Body,
    System,
    Torque,
    closed,
    homogeneous,
    move,
    orient,
    parameter,
    rotation,
)
from kinolab.errors import EndpointError, InputError
from kinolab.problem import PlanningTask
from tests import loops
from tests.support import plan

Array = NDArray[np.float64]

RACER = """\
[world]
bounds = { x = [-5, 5], y = [-5, 5] }
[bounds]
x_dot = [-3, 3]
y_dot = [-3, 3]
th_dot = [-3, 3]
ph_dot = [-3, 3]
[goal]
x = 1.0
tolerance = 0.3
at_rest = false
"""


def racing(folder: Path, **start: float) -> Path:
    return loops.written(folder, loops.roller_racer(), loops.section("start", start) + RACER)


def linked(folder: Path, **start: float) -> Path:
    goal = "[goal]\na = 2.0\ntolerance = 0.1\n"
    return loops.written(folder, loops.four_bar(), loops.section("start", start) + goal)


def proposed(text: str) -> dict[str, float]:
    """The values that an error message says to write."""
    found = re.findall(r"(\w+) = (-?[\d.e+-]*\d)", text)
    return {name: float(value) for name, value in found}


def test_a_slipping_axle_is_refused_by_name_size_and_unit(tmp_path: Path) -> None:
    slips = np.abs(loops.rows_of_racer(0.0, 0.4) @ [0.3, 0.195, 0.0, 0.0])
    assert slips[0] == pytest.approx(0.195)
    problem = kinolab.load(racing(tmp_path, x_dot=0.3, y_dot=0.195, ph=0.4))
    sizes = f"'the rear axle' by 0.195 m/s, 'the front axle' by {slips[1]:.3g} m/s."
    with pytest.raises(EndpointError, match=re.escape(sizes)):
        problem.solve(max_iterations=10)
    with pytest.raises(InputError, match=r"roller_racer.toml \[start\]: it breaks"):
        simulate(problem, 1.0)


def test_commands_end_at_once_and_what_they_propose_is_accepted(tmp_path: Path) -> None:
    given = {"x_dot": 0.3, "y_dot": 0.195, "ph": 0.4}
    name = racing(tmp_path, **given).name
    refused = plan(name, cwd=tmp_path)
    assert refused.returncode == 5
    simulated = plan("simulate", name, "--duration", "0.2", "--no-animation", cwd=tmp_path)
    assert simulated.returncode == 2
    assert not (tmp_path / "runs").exists()
    for done in (refused, simulated):
        assert "'the rear axle' by 0.195 m/s" in done.stderr
    better = racing(tmp_path, **(given | proposed(refused.stderr)))
    kinolab.load(better).check_endpoints()
    moved = plan("simulate", name, "--duration", "0.2", "--no-animation", cwd=tmp_path)
    assert moved.returncode == 0, moved.stderr


def test_a_start_whose_loop_is_open_is_refused_and_its_neighbour_is_planned_from(
    tmp_path: Path,
) -> None:
    given = {"a": 1.0, "b": -0.5, "c": 1.5}
    problem = kinolab.load(linked(tmp_path, **given))
    with pytest.raises(EndpointError) as error:
        problem.check_endpoints()
    assert "'the loop along x' by " in str(error.value)
    assert " m or rad" in str(error.value)  # its lengths are numbers without a unit
    better = kinolab.load(linked(tmp_path, **(given | proposed(str(error.value)))))
    better.check_endpoints()
    assert np.abs(better.start - problem.start).max() < 0.02  # [rad]


def test_a_start_that_holds_is_not_refused(tmp_path: Path) -> None:
    a, b, c, _ = loops.four_bar_state(1.3)
    problem = kinolab.load(linked(tmp_path, a=a, b=b, c=c, a_dot=2.0))
    assert list(problem.start_breaches()) == []
    problem = kinolab.load(racing(tmp_path, x_dot=0.3))
    assert list(problem.start_breaches()) == []


def test_loops_that_cannot_close_leave_nothing_to_propose(tmp_path: Path) -> None:
    a, b, c, _ = loops.four_bar_state(1.0)
    path = linked(tmp_path, a=a, b=b, c=c)
    path.write_text(path.read_text() + "[bounds]\na = [0.9, 1.1]\nc = [-1.0, -0.9]\n")
    problem: PlanningTask = kinolab.load(path, overrides=["start.c=-0.95"])
    with pytest.raises(EndpointError, match="no such state was found nearby"):
        problem.check_endpoints()


def test_an_attitude_is_proposed_as_a_quaternion(tmp_path: Path) -> None:
    """A mast whose top shall be 0.8 m up: it leans by acos 0.8, whichever way is nearest."""
    R = rotation("R", speed=2.0)
    mast = Body("mast", orient(R), mass=1.0, inertia=(0.3, 0.3, 0.1))
    top = homogeneous(mast.frame @ move(0, 0, 1))
    system = System(
        "mast",
        bodies=[mast],
        constraints=[closed(top[2, 3] - parameter("h", 0.8, "m"), "height")],
        inputs=[Torque("wind", on=mast, about=orient(R).x, limit=1.0)],
        velocities="all",
    )
    path = loops.written(tmp_path, system, "[start]\nR = [0.1, 0.0, 0.0, 1.0]\n[goal]\n")
    problem = kinolab.load(path)
    (mistake,) = problem.start_breaches()
    assert "'height' by 0.18 m" in mistake.what
    found = re.search(r"R = \[(.*?)\]", mistake.remedy)
    assert found
    x, y, z, w = map(float, found[1].split(","))
    assert [y, z] == pytest.approx([0, 0], abs=1e-6)
    assert 2 * np.arctan2(x, w) == pytest.approx(np.arccos(0.8), abs=1e-6)  # about the same axis
