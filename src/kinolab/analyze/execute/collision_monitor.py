"""Collision and workspace checks of perturbed machines."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, TypeAlias

from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.machine_facts import facts_of
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask

Fault: TypeAlias = Literal["collided", "strayed"]


class CollisionMonitor:
    """Checks motions of machines with other parameters in the world of a problem.

    A plan's margins to obstacles and cones are its reserve; here they are not added.

    Args:
        problem: The problem of the plan.
    """

    def __init__(self, problem: PlanningTask) -> None:
        world = replace(problem.world, clearance=0.0)
        cones = tuple(cone.forbidden for cone in problem.keep_outs)
        self._problem = replace(problem, world=world, keep_outs=cones)

    def first_fault(self, x: Array, built: Mechanism) -> tuple[int, Fault] | None:
        """Return the index of the first faulty state and its fault; None if there is none.

        Args:
            x: States, shape (N, nx).
            built: The actual machine.
        """
        problem, model = self._as_built(built), self._problem.model
        parameters = built.parameter_values
        frames = model.frames(x, **parameters)
        ends = model.cables(x, **parameters) if problem.cables else None
        hit = problem.checker().first_collision(frames, ends)
        for k in range(len(x) if hit is None else hit):
            if any(True for _ in problem.outside_world(frames[k])):
                return k, "strayed"
        return None if hit is None else (hit, "collided")

    def goal_excess(self, x: Array, parameters: dict[str, float]) -> float:
        """Return the goal error at a state (nx,), in tolerances of the plan."""
        goal, model = self._problem.goal, self._problem.model
        return goal.excess(x, model.frames(x, **parameters) if goal.needs_frames else None)

    def _as_built(self, system: Mechanism) -> PlanningTask:
        """Return the problem of the actual machine: its shapes may depend on parameters.

        If they do not, it is the same one, whose mesh search trees exist already.
        """
        built = replace(self._problem, machine=facts_of(system))
        same = built.bodies == self._problem.bodies and built.cables == self._problem.cables
        return self._problem if same else built
