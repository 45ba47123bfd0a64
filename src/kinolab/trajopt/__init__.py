"""Trajectory optimisation after the search: exact goals and shorter durations."""

from kinolab.trajopt.exact import make_exact
from kinolab.trajopt.segments import is_long
from kinolab.trajopt.shortening.shorten import shorten, shortened

__all__ = ["is_long", "make_exact", "shorten", "shortened"]
