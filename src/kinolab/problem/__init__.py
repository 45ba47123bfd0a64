"""A machine in a world with a start and a goal: all that a planner needs to know."""

from kinolab.problem.task import PlanningTask

__all__ = ["PlanningTask"]
