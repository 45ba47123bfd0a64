"""Assertions for user tests: a trajectory is collision-free, or dynamically feasible."""

from __future__ import annotations

from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.verification import collision_check, dynamics_checks


def assert_collision_free(problem: PlanningTask, trajectory: Trajectory) -> None:
    """Assert that the re-simulated motion is collision-free.

    Raises:
        AssertionError: That says when, which body and which obstacle.
    """
    check = collision_check(problem, trajectory)
    assert check.passed, str(check)


def assert_dynamically_feasible(problem: PlanningTask, trajectory: Trajectory) -> None:
    """Assert that the motion satisfies the equations of motion, constraints and input limits.

    Raises:
        AssertionError: That says when, which state or input, and by how much.
    """
    failures = [str(c) for c in dynamics_checks(problem, trajectory) if not c.passed]
    assert not failures, "\n".join(failures)
