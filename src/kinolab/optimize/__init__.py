"""Exact goals and short trajectories: optimisation after the search."""

from kinolab.optimize.allowance import AbstractAllowance, Seconds, Spent, Subproblems
from kinolab.optimize.repairing import is_long, repair
from kinolab.optimize.shortening import shorten

__all__ = [
    "AbstractAllowance",
    "Seconds",
    "Spent",
    "Subproblems",
    "is_long",
    "repair",
    "shorten",
]
