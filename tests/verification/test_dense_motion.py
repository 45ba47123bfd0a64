"""A true motion, looked at: nothing moves farther between two looks than it may."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.simulation.reference import follow_map, reference_motion
from kinolab.trajectory import Trajectory
from kinolab.verification.between_samples.dense_motion import MAX_SPACING, DenseMotion, TooFastError
from tests.support import OPEN, problem_of

SPANS = np.array([0.1, 0.25, 0.05, 0.4])


def test_steps_of_several_lengths_are_eulers() -> None:
    """A unicycle's: x' = v cos theta, y' = v sin theta, theta' = w."""
    model = kinolab.systems.get("unicycle1_v0").model()
    u = np.array([[0.5, 0.2], [-0.3, 0.4], [0.1, -0.5], [0.5, 0.0]])
    x = model.steps([0.1, -0.2, 0.7], u, SPANS, method="euler")
    theta = 0.7 + np.concatenate([[0.0], np.cumsum(u[:, 1] * SPANS)])
    way = (u[:, 0] * SPANS)[:, None] * np.column_stack([np.cos(theta[:-1]), np.sin(theta[:-1])])
    assert x[:, 2] == pytest.approx(theta, abs=1e-14)
    assert np.diff(x[:, :2], axis=0) == pytest.approx(way, abs=1e-14)
    each = model.step(x[:-1], u, SPANS, method="euler")
    assert each[:, :2] - x[:-1, :2] == pytest.approx(way, abs=1e-14)


def test_between_the_states_of_a_map_the_way_is_straight() -> None:
    model = kinolab.systems.get("unicycle1_v0").model()
    t = np.concatenate([[0.0], np.cumsum(SPANS)])
    motion = follow_map(model, np.zeros(3), t, np.full((4, 2), 0.5), "euler")
    knots = np.array([0, 0, 2, 3, 3])
    share = np.array([0.0, 0.5, 0.25, 0.5, 1.0])
    found = motion.along(knots, t[knots] + share * SPANS[knots])
    expected = (1 - share)[:, None] * motion.x[knots] + share[:, None] * motion.x[knots + 1]
    assert found == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("truth", ["continuous", "discrete"])
def test_a_rolling_coin_is_seen_at_every_centimetre_of_its_rim(truth: str, tmp_path: Path) -> None:
    """It rolls straight at 1 m/s: its centre makes 1 m/s too, no point of it as a body more."""
    rolls = ("start.phi_dot=4.0", f'integration.truth="{truth}"')
    problem = problem_of(tmp_path, OPEN, *rolls)
    t, u = np.linspace(0.0, 1.0, 21), np.zeros((20, 2))
    motion = reference_motion(problem, problem.start, t, u)
    names = (problem.model.state_names, problem.model.control_names)
    walk = DenseMotion(problem, Trajectory(t, motion.x, u, *names), motion)
    times, states, held = map(np.concatenate, zip(*walk.samples(), strict=True))
    assert (np.diff(times) >= 0).all()
    assert (times[0], times[-1]) == (0.0, 1.0)
    assert held.shape == (len(times), 2)
    x = states[:, problem.model.state_names.index("x")]
    assert np.diff(x).max() <= MAX_SPACING
    assert x - x[0] == pytest.approx(times, abs=1e-6)


def test_what_is_too_fast_to_be_looked_at_is_not_looked_at(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "start.phi_dot=1e9")
    t, u = np.array([0.0, 1.0]), np.zeros((1, 2))
    motion = reference_motion(problem, problem.start, t, u)
    names = (problem.model.state_names, problem.model.control_names)
    with pytest.raises(TooFastError, match="too fast"):
        list(DenseMotion(problem, Trajectory(t, motion.x, u, *names), motion).samples())
