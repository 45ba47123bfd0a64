"""Exact goals and short trajectories: optimisation after the search."""

from kinolab.search.budget import AbstractAllowance, Seconds, Spent, Subproblems
from kinolab.trajopt.exact import is_long, repair
from kinolab.trajopt.shortening.shorten import shorten

__all__ = [
    "AbstractAllowance",
    "Seconds",
    "Spent",
    "Subproblems",
    "is_long",
    "repair",
    "shorten",
]
