"""What optimised motions must satisfy: gaps as wide as their reserve, limits between knots."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.dynamics import Body, Control, Potential, Sphere, System, Wrench, length, move
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.problem import PlanningTask
from kinolab.simulation.collision_context import resolution
from kinolab.simulation.reference import resimulate
from kinolab.trajectory import Trajectory
from kinolab.trajopt.nlp.decision import even_knots
from kinolab.trajopt.nlp.feasibility_check import excess_between_knots, satisfies_all
from kinolab.trajopt.nlp.problem import TrajectoryProblem
from tests.support import OPEN, problem_of

HALF = 0.025  # [m] half the thickness of the coin, which rolls along x

# --- gaps ---

PAST_A_WALL = (
    OPEN.replace("x = 0.0\ny = 0.0", "x = 1.0\ny = 0.0")
    + """
[[world.obstacle]]
box = [0.6, 0.1, 1.0]
position = [0.0, MIDDLE, 0.5]
"""
)


def past_a_wall(folder: Path, gap: float) -> tuple[PlanningTask, Trajectory]:
    """Return a coin that rolls past a wall at 1 m/s, or through it."""
    text = PAST_A_WALL.replace("MIDDLE", str(HALF + gap + 0.05))
    problem = problem_of(folder, text, "start.phi_dot=4.0")
    return problem, resimulate(problem, np.linspace(0.0, 2.0, 41), np.zeros((40, 2)))


@pytest.mark.parametrize(("gap", "free"), [(0.003, True), (0.001, True), (-0.001, False)])
def test_a_gap_as_wide_as_the_reserve_is_no_collision(
    gap: float, free: bool, tmp_path: Path
) -> None:
    """The planners' check wants half its resolution of room: 5 mm, where the start has as much."""
    problem, motion = past_a_wall(tmp_path, gap)
    assert motion.x[-1, 0] == pytest.approx(1.0, abs=1e-6)
    assert resolution(problem) / 2 > abs(gap)
    task = TrajectoryProblem(problem, 0.0005 / TrajectoryProblem(problem, 0.0).bare.size)
    assert satisfies_all(task, motion) == free
    assert kinolab.verify(problem, motion).passed == free


# --- limits between knots ---

STIFFNESS, STEP, MOST = 100.0, 0.3, 0.5  # [N/m] for 1 kg: 10 rad/s, [s], [m/s]
SWING = f"""
schema = 1
title = "A mass on a spring between two knots"
[system]
file = "machine.json"
[bounds]
x_dot = [-{MOST}, {MOST}]
[start]
x = 0.1
[goal]
x = 0.0
tolerance = 2.0
[integration]
step = {STEP}
substeps = 20
"""


def swing(folder: Path) -> PlanningTask:
    """Return a mass of 1 kg on a spring."""
    x = length("x", -4, 4, speed=2.0)
    push = Control("push", limit=2.0, unit="N")
    body = Body("mass", move(x, 0, 0), mass=1.0, shape=Sphere(0.01))
    efforts = [Potential(STIFFNESS * x**2 / 2), Wrench(on=body, force=(push.symbol, 0, 0))]
    system = System("swing", bodies=[body], inputs=[push], efforts=efforts)
    folder.mkdir(exist_ok=True)
    (folder / "machine.json").write_text(machine_to_json(system), encoding="utf-8")
    return problem_of(folder, SWING)


def test_a_rate_that_peaks_between_knots_passes_its_limit_by_what_theory_says(
    tmp_path: Path,
) -> None:
    """From rest at x0 the mass moves at x0 w sin(w t): its rate peaks between two knots."""
    problem, w = swing(tmp_path), np.sqrt(STIFFNESS)
    motion = resimulate(problem, np.array([0.0, STEP]), np.zeros((1, 1)))
    rates = motion.x[:, 1]
    assert np.abs(rates).max() < MOST
    found = excess_between_knots(TrajectoryProblem(problem, 0.0), motion)
    assert found.limits[0] == 0.0
    assert found.limits[1] == pytest.approx(0.1 * w - MOST, rel=0.05)
    assert found


def test_limits_are_tightened_by_a_little_more_than_what_passes_them(tmp_path: Path) -> None:
    problem = swing(tmp_path)
    motion = resimulate(problem, np.array([0.0, STEP]), np.zeros((1, 1)))
    task = TrajectoryProblem(problem, 0.0)
    excess = excess_between_knots(task, motion)
    h = even_knots(problem, motion).h
    before, after = (one.scaling(h, h).x_bounds[1] for one in (task, task.tightened(excess)))
    assert before == pytest.approx([-MOST, MOST])
    inset = MOST - np.abs(after)
    assert (inset > excess.limits[1]).all()
    assert (inset < 1.5 * excess.limits[1]).all()
