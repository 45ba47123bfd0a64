"""The trailer of the car may not fold: the benchmark says so and never checks it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.errors import EndpointError
from kinolab.simulation import Propagator
from kinolab.simulation.reference import resimulate
from tests.scenario.dynobench.test_environments import PARK, written
from tests.support import detail, failed

LIMIT = np.pi / 4  # [rad] of the benchmark's diff_max_abs

OPEN = PARK[: PARK.index("  obstacles:")] + PARK[PARK.index("robots:") :]
HARD = np.tile([0.5, 1.04], (30, 1))  # 1.5 m, steered as far as it goes


def test_the_margin_is_what_is_left_of_the_limit_the_short_way_round() -> None:
    model = kinolab.systems.get("car1_v0").model()
    x = np.random.default_rng(0).uniform(-20, 20, (1000, 4))
    apart = np.abs((x[:, 2] - x[:, 3] + np.pi) % (2 * np.pi) - np.pi)
    np.testing.assert_allclose(model.requirements(x)[:, 0], LIMIT - apart, atol=1e-13)


def test_a_motion_that_folds_the_trailer_is_refused(tmp_path: Path) -> None:
    problem = kinolab.load(written(tmp_path, OPEN))
    motion = resimulate(problem, np.arange(31) * problem.step, HARD)
    folded = np.abs(motion.x[:, 2] - motion.x[:, 3])
    first = int(np.argmax(folded > LIMIT))
    assert 0 < first < 30
    certificate = kinolab.verify(problem, motion)
    assert "requirements" in failed(certificate)
    assert "the trailer does not fold" in detail(certificate, "requirements")
    propagator = Propagator(problem)
    for k, (x, u) in enumerate(zip(motion.x[: first + 1], HARD, strict=False)):
        assert propagator.step(x.tolist(), u.tolist(), problem.step)[1] == (k + 1 < first)
        if k + 1 == first:
            break


@pytest.mark.parametrize("planner", ["rrt_fast", "kpiece_fast", "rrt"])
def test_no_planner_folds_the_trailer(planner: str, tmp_path: Path) -> None:
    """To turn round in little room it would have to."""
    problem = kinolab.load(written(tmp_path, OPEN), overrides=["goal.tolerance=1.0"])
    limits = {"max_iterations": 50_000, "time_limit": 60.0}
    found = problem.solve(planner=planner, seed=1, optimize=False, **limits)
    assert found.status == "solved"
    assert found.trajectory is not None
    margins = problem.model.requirements(found.trajectory.x)
    assert margins.min() >= 0


def test_a_start_with_a_folded_trailer_is_told(tmp_path: Path) -> None:
    text = OPEN.replace("start: [0.7, 0.6, 0, 0]", "start: [0.7, 0.6, 1, 0]")
    with pytest.raises(EndpointError) as caught:
        kinolab.load(written(tmp_path, text)).check_endpoints()
    assert str(caught.value) == (
        "park.yaml [start]: it breaks a requirement (the trailer does not fold) by 0.214602."
    )
