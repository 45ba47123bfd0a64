"""Exact goals and short trajectories: optimisation after the search."""

from kinolab.optimize.repairing import repair
from kinolab.optimize.shortening import shorten

__all__ = ["repair", "shorten"]
