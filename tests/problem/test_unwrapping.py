"""q and -q are the same attitude, and whole turns of an angle do not show: nobody may mind them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import kinolab
from kinolab import systems
from kinolab.analyze.execute.conditions import Conditions
from kinolab.dynamics.facts.machine_facts import facts_of
from kinolab.loading import build_problem, find_scenario
from kinolab.numerics.manifolds.state_parts import RealLine
from kinolab.problem import PlanningTask
from kinolab.problem.unwrapping import unwrapped
from kinolab.runs import check_run, read_run, write_run
from kinolab.show.scene.keyframes import key_poses
from kinolab.simulation.reference import resimulate
from kinolab.solve import PlanResult
from kinolab.testing import assert_dynamically_feasible
from kinolab.trajectory import Trajectory
from kinolab.verification import Certificate, dynamics_checks, verify
from kinolab.verification.checks.knot_defects import DEFECT_TOLERANCE
from tests.conftest import Solver
from tests.executions import execute
from tests.support import failed

Array = NDArray[np.float64]

STEPS = 12
RIDING = {"whipple": {"theta_R_dot": 17.0}}
LEFT_ALONE = {"helicopter": ["system.parameters.v_0=1e3"]}  # by itself it drifts to its side


# Machines with neither attitudes nor angles on a circle.
UNTURNED = {"biped", "crane", "five_bar", "panda", "two_cranes"}
TURNING = sorted(set(systems.names()) - UNTURNED)


def test_machines_that_are_left_out_have_one_description_of_each_configuration() -> None:
    for name in UNTURNED:
        parts = facts_of(systems.get(name)).parts
        assert all(isinstance(part, RealLine) for part in parts)


@cache
def motion_of(name: str) -> tuple[PlanningTask, Trajectory]:
    """A machine by itself, moving for a while under inputs near the middle of their limits."""
    scenario = find_scenario(name, overrides=LEFT_ALONE.get(name, ()))
    problem = build_problem(scenario, planning=False, planner=False)
    start, rng = problem.start.copy(), np.random.default_rng(5)
    for entry, value in RIDING.get(name, {}).items():
        start[problem.model.state_names.index(entry)] = value
    problem = replace(problem, start=start)
    lower, upper = problem.model.control_bounds.T
    idle, half = np.clip(0.0, lower, upper), (upper - lower) / 2
    shares = 0.1 * rng.uniform(-1, 1, (STEPS, problem.model.nu))
    u = np.clip(idle + shares * np.where(np.isfinite(half), half, 1.0), lower, upper)
    t = problem.step * np.arange(STEPS + 1)
    return problem, resimulate(problem, t, u)


@cache
def plainly_verified(name: str) -> Certificate:
    """The certificate of the motion in the numbers that it was made in."""
    return verify(*motion_of(name))


def disguised(problem: PlanningTask, trajectory: Trajectory, seed: int) -> Trajectory:
    """The same states in other numbers, each row by itself; seed 0 negates all quaternions."""
    rng, x = np.random.default_rng(seed), trajectory.x.copy()
    for first in problem.model.attitudes.values():
        signs = rng.choice([-1.0, 1.0], size=(len(x), 1)) if seed else -1.0
        x[:, first : first + 4] *= signs
    turns = rng.integers(-3, 4, size=x.shape) if seed else np.ones_like(x)
    return replace(trajectory, x=x + 2 * np.pi * np.where(problem.circular, turns, 0))


@pytest.mark.parametrize("name", TURNING)
@pytest.mark.parametrize("seed", range(3))
def test_any_signs_and_whole_turns_are_accepted(name: str, seed: int) -> None:
    problem, trajectory = motion_of(name)
    other = disguised(problem, trajectory, seed)
    assert not np.array_equal(other.x, trajectory.x)
    checks = dynamics_checks(problem, other)
    assert all(check.passed for check in checks), [str(c) for c in checks if not c.passed]
    assert_dynamically_feasible(problem, other)
    plain, seen = plainly_verified(name), verify(problem, other)
    assert failed(seen) == failed(plain)  # by itself it may well leave its limits
    for one, same in zip(plain.checks, seen.checks, strict=True):
        assert same.value == pytest.approx(one.value, rel=1e-5, abs=1e-9)  # rounding of the turns


@pytest.mark.parametrize("name", TURNING)
@pytest.mark.parametrize("seed", range(3))
def test_numbers_without_jumps_come_back(name: str, seed: int) -> None:
    problem, trajectory = motion_of(name)
    back = unwrapped(problem, disguised(problem, trajectory, seed))
    np.testing.assert_allclose(back.x, trajectory.x, rtol=0, atol=1e-13)  # [rad]
    np.testing.assert_array_equal(unwrapped(problem, trajectory).x, trajectory.x)


@pytest.mark.parametrize("name", TURNING)
def test_a_damaged_motion_is_refused_in_any_numbers(name: str) -> None:
    """Four times what a knot may be off by is no whole turn, and no other sign."""
    problem, trajectory = motion_of(name)
    for k in np.flatnonzero(problem.circular):
        check_refused(problem, trajectory, int(k), 4 * DEFECT_TOLERANCE * problem.scales[k])
    for first in problem.model.attitudes.values():
        turned = trajectory.x.copy()
        # half of it is what a quaternion moves by
        by = Rotation.from_rotvec([8 * DEFECT_TOLERANCE, 0, 0])
        rows = Rotation.from_quat(turned[:, first : first + 4]) * by
        turned[7:, first : first + 4] = rows.as_quat()[7:]
        refused = disguised(problem, replace(trajectory, x=turned), 1)
        assert "dynamics" in refusals(problem, refused)


def refusals(problem: PlanningTask, trajectory: Trajectory) -> set[str]:
    """What is refused of a motion for its dynamics alone."""
    return {check.name for check in dynamics_checks(problem, trajectory) if not check.passed}


def check_refused(problem: PlanningTask, trajectory: Trajectory, entry: int, change: float) -> None:
    x = trajectory.x.copy()
    x[7, entry] += change
    refused = disguised(problem, replace(trajectory, x=x), 1)
    assert "dynamics" in refusals(problem, refused)


def test_a_difference_knows_what_is_the_same() -> None:
    problem, trajectory = motion_of("satellite")
    x, other = trajectory.x, disguised(problem, trajectory, 2).x
    assert np.abs(problem.space.difference(x, other)).max() < 1e-14
    assert np.abs(problem.space.difference(other, x)).max() < 1e-14
    first = problem.model.attitudes["R"]
    apart = problem.space.difference(-other[0], x[1])[first : first + 4]
    a, b = (Rotation.from_quat(row[first : first + 4]) for row in x[:2])
    assert 4 * np.arcsin(np.linalg.norm(apart) / 2) == pytest.approx((a.inv() * b).magnitude())


@pytest.fixture
def pointing(solved: Solver, tmp_path: Path) -> tuple[PlanningTask, Path, PlanResult]:
    """The satellite's plan and a folder of its run."""
    found = solved("satellite_pointing")
    write_run(tmp_path, found.problem, found.plan)
    return found.problem, tmp_path, found.plan


@pytest.mark.parametrize("seed", range(3))
def test_a_file_with_other_signs_passes_and_a_damaged_one_does_not(
    seed: int, pointing: tuple[PlanningTask, Path, PlanResult]
) -> None:
    problem, folder, plan = pointing
    assert plan.trajectory is not None
    other = disguised(problem, plan.trajectory, seed)
    (folder / "trajectory.npz").unlink(missing_ok=True)  # as from elsewhere: it would differ
    (folder / "trajectory.csv").write_text(other.to_csv(), encoding="utf-8")
    assert failed(check_run(folder)) == {"files"}  # it is another file that proves the same
    assert kinolab.verify(problem, other).passed
    x = other.x.copy()
    first = problem.model.attitudes["R"]
    x[len(x) // 2, first] *= -1  # one number of the four
    (folder / "trajectory.csv").write_text(replace(other, x=x).to_csv(), encoding="utf-8")
    assert "dynamics" in failed(check_run(folder))


def test_a_file_with_other_signs_is_carried_out_and_shown_the_same(
    pointing: tuple[PlanningTask, Path, PlanResult],
) -> None:
    """Gains along the plan, and curves between its knots, are made of one state and the next."""
    problem, folder, plan = pointing
    assert plan.trajectory is not None
    other = disguised(problem, plan.trajectory, 1)
    (folder / "trajectory.csv").write_text(other.to_csv(), encoding="utf-8")
    read = read_run(folder).trajectory
    np.testing.assert_allclose(read.x, plan.trajectory.x, rtol=0, atol=1e-12)
    wrong = Conditions(parameters=0.02)
    one, same = (
        execute(problem, trajectory, wrong, runs=1) for trajectory in (plan.trajectory, other)
    )
    for a, b in zip(one.runs, same.runs, strict=True):
        np.testing.assert_allclose(a.off, b.off, rtol=1e-3, atol=1e-6)
    shown, again = (key_poses(problem, trajectory) for trajectory in (plan.trajectory, read))
    for curve, alike in zip(shown.turns, again.turns, strict=True):
        np.testing.assert_allclose(curve.values, alike.values, rtol=0, atol=1e-9)
