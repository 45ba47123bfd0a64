"""Problem -> planner -> re-simulation -> verification -> optimisation -> Plan, for any seeds."""

from kinolab.solve.pipeline import solve
from kinolab.solve.plan import EXIT_CODES, Attempt, Improvement, PlanResult, make_planner

__all__ = ["EXIT_CODES", "Attempt", "Improvement", "PlanResult", "make_planner", "solve"]
