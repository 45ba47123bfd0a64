"""Exact goals and short trajectories: optimisation after the search."""

from kinolab.optimize.allowance import AbstractAllowance, Seconds, Subproblems
from kinolab.optimize.repairing import repair
from kinolab.optimize.shortening import shorten

__all__ = ["AbstractAllowance", "Seconds", "Subproblems", "repair", "shorten"]
