"""What the optimiser drives is no shorter than the shortest curves, by an oracle of its own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.trajopt import make_exact, shorten
from tests.oracles.vehicles import Pose, dubins_length, path_length, reeds_shepp_length
from tests.support import problem_of
from tests.trajopt.test_trajopt import EXACT, PATIENCE, straight_to

ORIGIN = (0.0, 0.0, 0.0)
FASTEST, BACKWARD, SLOWEST, TURNING = 0.5, 0.1, 0.25, 0.5  # [m/s], and [rad/s]
TIGHTEST = 0.25 / 1.7320510  # [m]: wheelbase over the tangent of the largest steering angle
ROUNDING = 1e-6  # [m]
DRIVE = """
schema = 1
title = "A vehicle drives to a pose, with nothing in its way"
system = {{ name = "{machine}" }}
world.bounds = {{ x = [-9, 9], y = [-9, 9] }}
[goal]
{goal}
tolerance = 0.05
[integration]
step = 0.1
"""


def driven(folder: Path, machine: str, goal: dict[str, float], steps: int) -> Trajectory:
    """Return the motion that repair and shortening make of a straight line."""
    lines = "\n".join(f"{name} = {value!r}" for name, value in goal.items())
    problem = problem_of(folder, DRIVE.format(machine=machine, goal=lines))
    exact = make_exact(problem, straight_to(problem, steps))
    assert exact is not None
    short = shorten(problem, exact, PATIENCE)
    assert short.duration < exact.duration
    assert problem.goal_distance(short.x[-1]) < EXACT
    assert verified(problem, short)
    return short


def verified(problem: PlanningTask, trajectory: Trajectory) -> bool:
    certificate = kinolab.verify(problem, trajectory)
    assert certificate.passed, [str(check) for check in certificate.failures]
    return True


@pytest.mark.parametrize("goal", [(4.0, 1.0, 1.0), (2.0, 2.0, 2.0)])
def test_what_only_drives_ahead_keeps_to_dubins_curves(goal: Pose, tmp_path: Path) -> None:
    """Slow it turns within 0.5 m, at full speed within 1 m.

    No way is shorter than Dubins' for the small radius; his for the large one, at full speed, is
    a motion that keeps all limits, and these goals are reached as quickly but for 1 % and a step.
    """
    named = dict(zip(("x", "y", "theta"), goal, strict=True))
    quick = dubins_length(ORIGIN, goal, FASTEST / TURNING) / FASTEST
    short = driven(tmp_path, "unicycle1_v1", named, int(25 * quick))
    length = path_length(short, ("x", "y", "theta"))
    assert length >= dubins_length(ORIGIN, goal, SLOWEST / TURNING) - ROUNDING
    assert length <= FASTEST * short.duration + ROUNDING
    assert short.duration <= 1.01 * quick + 0.1


@pytest.mark.parametrize("goal", [(1.2, -0.4, 0.0), (-0.3, 0.0, 0.0)])
def test_a_car_that_parks_keeps_to_reeds_and_shepps_curves(goal: Pose, tmp_path: Path) -> None:
    """Its trailer only makes it longer, and backward it is slow."""
    x, y, heading = goal
    named = {"x": x, "y": y, "theta_0": heading, "theta_1": heading}
    short = driven(tmp_path, "car1_v0", named, 100)
    length = path_length(short, ("x", "y", "theta_0"))
    least = reeds_shepp_length(ORIGIN, goal, TIGHTEST)
    assert length >= least - ROUNDING
    assert short.duration >= least / FASTEST - ROUNDING
    if x < 0:  # straight back is the shortest way, and the quickest one
        assert length == pytest.approx(least, abs=1e-3)
        assert short.duration == pytest.approx(least / BACKWARD, rel=0.01)


def test_the_tightest_turn_is_that_of_the_car() -> None:
    """At the largest steering angle, heading over way is one over the radius."""
    model = kinolab.systems.get("car1_v0").model()
    largest = model.control_bounds[1, 1]
    rates = model.f(np.zeros(4), np.array([1.0, largest]))
    assert rates[0] / rates[2] == pytest.approx(TIGHTEST, rel=1e-6)
