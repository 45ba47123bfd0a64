"""A biped whose footsteps are part of its plan."""

from __future__ import annotations

import numpy as np
import pytest

import kinolab
from kinolab.simulation.reference import reference_motion
from tests.oracles.biped import Biped, Side, foot_place, stance_rates

ROBOT = Biped(h=0.0)


@pytest.fixture(scope="module")
def problem() -> kinolab.Problem:
    return kinolab.load("biped_walk")


@pytest.fixture(scope="module")
def plan(problem: kinolab.Problem) -> kinolab.Plan:
    found = problem.solve(seed=3, improve=1.0)  # [s] of work, some more than an exact end takes
    assert found.status == "solved", found.message
    return found


def oracle_of(problem: kinolab.Problem, x: np.ndarray) -> np.ndarray:
    """Return q of the oracle, whose torso leans the other way."""
    value = dict(zip(problem.model.state_names, x, strict=True))
    joints = [value[f"{n}_{s}"] for s in ("left", "right") for n in ("hip", "knee")]
    return np.array([value["x"], value["z"], -value["lean"], *joints])


@pytest.mark.parametrize("k", [0, 1])
def test_velocities_are_those_of_a_pinned_foot(problem: kinolab.Problem, k: int) -> None:
    model, generator = problem.model, np.random.default_rng(k)
    side: Side = ("left", "right")[k]
    for _ in range(20):
        x = np.append(generator.uniform(-0.5, 0.5, model.nx - 1), float(k))
        u = generator.uniform(-1, 1, model.nu)
        given = dict(zip(model.control_names, u, strict=True))
        joints = [given[f"{n}_{s}_rate"] for s in ("left", "right") for n in ("hip", "knee")]
        turned = np.array([-given["bend"], *joints])
        expected = stance_rates(oracle_of(problem, x), turned, side, ROBOT)
        found = oracle_of(problem, np.append(model.f(x, u)[:-1], 0.0))
        assert np.abs(found - expected).max() < 1e-12


def test_it_steps_over_blocks_and_ends_in_the_goals_centre(plan: kinolab.Plan) -> None:
    x = plan.trajectory.x
    assert np.count_nonzero(np.diff(x[:, -1])) >= 4  # steps
    assert abs(x[-1, 0] - 4.3) < 1e-6
    assert plan.trajectory.duration < plan.statistics["raw_duration"]


def test_a_foot_that_stands_stays_where_it_is(problem: kinolab.Problem, plan: kinolab.Plan) -> None:
    """By the hand-written kinematics, at a hundred times in every step of the true motion."""
    trajectory = plan.trajectory
    motion = reference_motion(problem, trajectory.x[0], trajectory.t, trajectory.u)
    standing: dict[float, np.ndarray] = {}
    drift = lowest = 0.0
    for k in range(len(trajectory.u)):
        for state in motion.between(k, np.linspace(trajectory.t[k], trajectory.t[k + 1], 100)):
            mode = float(round(state[-1]))
            side, other = ("left", "right") if mode == 0.0 else ("right", "left")
            q = oracle_of(problem, state)
            place = foot_place(q, side, ROBOT)  # type: ignore[arg-type]
            if mode not in standing:
                standing = {mode: place}
            drift = max(drift, float(np.abs(place - standing[mode]).max()))
            lowest = min(lowest, float(foot_place(q, other, ROBOT)[1]) - 0.06)  # type: ignore[arg-type]
    assert drift < 1e-9
    assert lowest > -1e-6
