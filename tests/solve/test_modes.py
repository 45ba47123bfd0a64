"""Plans of machines whose mechanics switch, and what is refused of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.errors import InputError
from kinolab.trajectory import Trajectory
from kinolab.verification import verify
from tests.oracles.hopper import Hopper

SCENARIO = """\
schema = 1
title = "A hopper hops"
[system]
file = "hopper.py:hopper"
[world]
bounds = { z = [-0.2, 3.0] }
[start]
z = 0.76
s = -0.04
[goal]
z = 1.2
tolerance = 0.03
[planner]
name = "rrt_fast"
time_limit = 60.0
[integration]
step = 0.02
substeps = 4
"""
SOURCE = """
from kinolab.dynamics import *


def hopper():
    z, s = length("z", 0.3, 3.0, speed=8.0), length("s", -0.5, 0.5, speed=20.0)
    body, foot = move(0, 0, z), move(0, 0, z - 0.8 - s)
    standing = closed(z - 0.8 - s, "foot on the ground")
    return System(
        "hopper",
        bodies=[
            Body("body", body, mass=8.0, shape=Sphere(0.15)),
            Body("foot", foot, mass=1.0, shape=Sphere(0.05), touches_ground=True),
        ],
        efforts=[Potential(2000.0 * s**2 / 2)],
        inputs=[Pull("leg", between=(body, foot), limit=(-200.0, 200.0))],
        gravity=toward("-z", 9.81),
        modes=[Mode("stance", constraints=[standing]), Mode("flight")],
        transitions=[
            Transition("lift off", "stance", "flight", until=force_of(standing)),
            Transition("land", "flight", "stance", until=z - 0.8 - s),
        ],
    )
"""


@pytest.fixture(scope="module")
def problem(tmp_path_factory: pytest.TempPathFactory) -> kinolab.Problem:
    folder = tmp_path_factory.mktemp("hopping")
    (folder / "hopper.py").write_text(SOURCE)
    (folder / "hop.toml").write_text(SCENARIO)
    return kinolab.load(folder / "hop.toml")


@pytest.fixture(scope="module")
def plan(problem: kinolab.Problem) -> kinolab.Plan:
    found = problem.solve(seed=1)
    assert found.status == "solved", found.message
    return found


@pytest.fixture(scope="module")
def landing(problem: kinolab.Problem) -> kinolab.Plan:
    """As it was found: the shortest plan hops once and does not land."""
    found = problem.solve(seed=1, optimize=False)
    assert found.status == "solved", found.message
    return found


def test_it_hops_as_high_as_it_must(plan: kinolab.Plan) -> None:
    x = plan.trajectory.x
    assert {0.0, 1.0} == set(x[:, -1])  # it stood, and it flew
    assert abs(x[-1, 0] - 1.2) <= 0.03


def test_flights_between_knots_are_those_of_the_closed_form(plan: kinolab.Plan) -> None:
    """A force F of the leg moves the spring's middle by F / k, as another length at rest does."""
    trajectory, flown = plan.trajectory, 0
    for k, (force,) in enumerate(trajectory.u):
        moved = np.array([0.0, force / 2000.0, 0.0, 0.0])
        oracle = Hopper(L=0.8 - force / 2000.0)
        before, after = (trajectory.x[i][:4] + moved for i in (k, k + 1))
        span = trajectory.t[k + 1] - trajectory.t[k]
        flies = trajectory.x[k, -1] == trajectory.x[k + 1, -1] == 1.0
        if flies and oracle.touch_down(before) > span:
            assert np.abs(after - oracle.flight(before, span)).max() < 1e-7
            flown += 1
    assert flown > 3


@pytest.mark.parametrize("change", ["mode skipped", "landing left out", "mode of its own"])
def test_a_plan_that_breaks_its_transitions_is_refused(
    problem: kinolab.Problem, landing: kinolab.Plan, change: str
) -> None:
    x = landing.trajectory.x.copy()
    flying = np.flatnonzero(x[:, -1] == 1.0)
    assert 0.0 in x[flying[0] :, -1]  # it lands
    if change == "mode skipped":
        x[flying, -1] = 0.0
    elif change == "landing left out":
        x[flying[0] :, -1] = 1.0
    else:
        x[:, -1] = 0.5
    false = replace(landing.trajectory, x=x)
    certificate = verify(problem, false)
    assert not certificate.passed


@pytest.mark.parametrize("z_dot", [-1.0, 1.0])
def test_a_flight_by_the_closed_form_is_no_more_sensitive_than_it_is(
    problem: kinolab.Problem, z_dot: float
) -> None:
    """An error of the start turns with the leg's swing, and grows by no more than its stretch."""
    start = {"start.mode": 1, "start.z": 1.4, "start.s": 0.0, "start.z_dot": z_dot}
    flying = problem.replace({**start, "goal.tolerance": 5.0})
    t = np.linspace(0.0, 0.1, 6)
    x = np.array([[*Hopper().flight(flying.start[:4], time), 1.0] for time in t.tolist()])
    motion = Trajectory(t, x, np.zeros((5, 1)), flying.model.state_names, ("leg",))
    certificate = verify(flying, motion)
    assert certificate.passed, str(certificate)
    growth = next(check.value for check in certificate.checks if check.name == "error growth")
    w = np.sqrt(2000.0 * 9.0 / 8.0)  # of the stretch; scales: 8 m/s and 20 m/s of rates, else 1
    assert growth < w


def test_planners_that_steer_or_optimise_refuse(problem: kinolab.Problem) -> None:
    for name in ("prm", "prm_geometric", "potential_field", "shooting", "kinematic_first"):
        with pytest.raises(InputError, match=f"{name} does not plan for machines with modes"):
            problem.solve(planner=name)


def test_a_start_in_no_mode_is_refused_with_their_names(problem: kinolab.Problem) -> None:
    with pytest.raises(InputError, match="Give 0 for stance, 1 for flight"):
        problem.replace(**{"start.mode": 2})
    assert problem.replace(**{"start.mode": 1}).start[-1] == 1.0


def test_pages_and_folders_are_written(plan: kinolab.Plan, tmp_path: Path) -> None:
    plan.save(tmp_path / "run")
    assert kinolab.read_run(tmp_path / "run").trajectory.x.tobytes() == plan.trajectory.x.tobytes()


BALL = """
from kinolab.dynamics import *


def ball():
    z = length("z", -1.0, 10.0, speed=10.0)
    ball = Body("ball", move(0, 0, z), mass=1.0, shape=Sphere(0.1), touches_ground=True)
    return System(
        "ball",
        bodies=[ball],
        inputs=[Force("thrust", on=ball, along=WORLD.z, limit=(0.0, 15.0))],
        gravity=toward("-z", 9.81),
        modes=[Mode("flight")],
        transitions=[
            Transition("bounce", "flight", "flight", until=z - 0.1, restitution=0.7)
        ],
    )
"""


@pytest.mark.parametrize("planner", ["rrt_fast", "rrt"])
def test_a_machine_with_one_mode_that_bounces_into_itself_is_planned_for(
    planner: str, tmp_path: Path
) -> None:
    text = SCENARIO.replace("hopper.py:hopper", "ball.py:ball").replace("s = -0.04\n", "")
    (tmp_path / "ball.py").write_text(BALL)
    (tmp_path / "ball.toml").write_text(text.replace("z = 0.76", "z = 0.5").replace("0.03", "0.2"))
    problem = kinolab.load(tmp_path / "ball.toml")
    plan = problem.solve(planner=planner)
    assert plan.status == "solved"
    assert plan.trajectory is not None
    assert set(plan.trajectory.x[:, -1]) == {0.0}
    assert abs(plan.trajectory.x[-1, 0] - 1.2) <= 0.2
