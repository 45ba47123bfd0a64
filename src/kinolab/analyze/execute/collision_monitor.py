"""What a machine that is not quite as planned runs into, and where it may not go."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, TypeAlias

from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask

Fault: TypeAlias = Literal["collided", "strayed"]


class CollisionMonitor:
    """Judges motions of machines with other parameters in the world of a problem.

    What a plan keeps from obstacles and cones is its reserve; here they count as they are.

    Args:
        problem: Of the plan.
    """

    def __init__(self, problem: PlanningTask) -> None:
        world = replace(problem.world, clearance=0.0)
        cones = tuple(cone.forbidden for cone in problem.keep_outs)
        self._problem = replace(problem, world=world, keep_outs=cones)

    def first_fault(self, x: Array, built: Mechanism) -> tuple[int, Fault] | None:
        """Return the first state in which something is wrong, and what; None for a sound motion.

        Args:
            x: States, shape (N, nx).
            built: The machine that was there.
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
        """Return how far outside the goal the machine is at a state, in tolerances of the plan."""
        goal, model = self._problem.goal, self._problem.model
        return goal.excess(x, model.frames(x, **parameters) if goal.needs_frames else None)

    def _as_built(self, system: Mechanism) -> PlanningTask:
        """Return the problem of a machine whose shapes follow its parameters: larger wheels, say.

        Where they do not, it is the same one, whose search trees of meshes are there.
        """
        built = replace(self._problem, system=system)
        same = built.bodies == self._problem.bodies and built.cables == self._problem.cables
        return self._problem if same else built
