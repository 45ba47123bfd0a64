"""Motions of the kinematic reduction, which the dynamics then follow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

from kinolab.planners.shooting import first_motion
from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner, Budget, SearchResult, setting
from kinolab.trajopt.multistart.kinematic_multistart import KinematicMultistart


@final
@dataclass(frozen=True, kw_only=True)
class KinematicFirst(AbstractPlanner):
    """Plans without masses first, velocities being inputs; the dynamics follow, more slowly.

    For machines whose inputs accelerate them along every velocity that nonholonomic constraints
    leave, such as a tractor with trailers. Solutions end exactly in the goal's centre.

    Source: Bullo, Lynch, Kinematic controllability for decoupled trajectory planning, IEEE Trans.
    Robotics and Automation 17(4), 2001.
    """

    name: ClassVar[str] = "kinematic_first"

    knots: int = setting(80, 10, 10_000, meaning="About how many knots a guess has.")

    def solve(self, problem: PlanningTask, seed: int, budget: Budget) -> SearchResult:
        """Optimise motions of the reduction, then with the dynamics, until one succeeds."""
        given = (problem, self.knots, seed, budget.expired, budget.below)
        return first_motion(problem, KinematicMultistart(*given), budget)
