"""The planning problem: a machine in a world, start, goal, limits and metric."""

from kinolab.problem.task import PlanningTask

__all__ = ["PlanningTask"]
