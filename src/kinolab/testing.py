"""Assertions for tests of one's own: is a trajectory collision-free, is it dynamically feasible?"""

from __future__ import annotations

from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.verification import collision_check, dynamics_checks


def assert_collision_free(problem: PlanningTask, trajectory: Trajectory) -> None:
    """Assert that the re-simulated motion touches nothing.

    Raises:
        AssertionError: That says when, which body and which obstacle.
    """
    check = collision_check(problem, trajectory)
    assert check.passed, str(check)


def assert_dynamically_feasible(problem: PlanningTask, trajectory: Trajectory) -> None:
    """Assert that the motion obeys the equations, the constraints and the inputs' limits.

    Raises:
        AssertionError: That says when, which state or input, and by how much.
    """
    failures = [str(c) for c in dynamics_checks(problem, trajectory) if not c.passed]
    assert not failures, "\n".join(failures)
