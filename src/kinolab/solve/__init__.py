"""Planning pipeline: problem -> search -> re-simulation -> verification -> optimisation -> plan."""

from kinolab.solve.pipeline import solve
from kinolab.solve.plan import EXIT_CODES, Attempt, Improvement, PlanResult, make_planner

__all__ = ["EXIT_CODES", "Attempt", "Improvement", "PlanResult", "make_planner", "solve"]
