"""Exact goals and short trajectories: optimisation after the search."""

from kinolab.trajopt.exact import is_long, make_exact
from kinolab.trajopt.shortening.shorten import shorten

__all__ = ["is_long", "make_exact", "shorten"]
