"""Problem -> planner -> re-simulation -> verification -> optimisation -> Plan, for any seeds."""

from kinolab.planning.attempt import make_planner
from kinolab.planning.plan import EXIT_CODES, Attempt, Improvement, Plan
from kinolab.planning.solving import solve

__all__ = ["EXIT_CODES", "Attempt", "Improvement", "Plan", "make_planner", "solve"]
