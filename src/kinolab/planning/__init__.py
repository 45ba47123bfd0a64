"""Problem -> planner -> re-simulation -> verification -> Plan, with one seed or with several."""

from kinolab.planning.attempt import make_planner
from kinolab.planning.plan import EXIT_CODES, Attempt, Plan
from kinolab.planning.solving import solve

__all__ = ["EXIT_CODES", "Attempt", "Plan", "make_planner", "solve"]
