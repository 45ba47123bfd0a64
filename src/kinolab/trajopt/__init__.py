"""Exact goals and short trajectories: optimisation after the search."""

from kinolab.search.budget import AbstractBudget, IsSpent, SubproblemBudget, TimeBudget
from kinolab.trajopt.exact import is_long, make_exact
from kinolab.trajopt.shortening.shorten import shorten

__all__ = [
    "AbstractBudget",
    "IsSpent",
    "SubproblemBudget",
    "TimeBudget",
    "is_long",
    "make_exact",
    "shorten",
]
