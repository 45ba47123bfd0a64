"""Artificial potentials: what pulls a machine to its goal, what keeps it off obstacles."""

from kinolab.search.potential.potential_search import FieldSettings, solve

__all__ = ["FieldSettings", "solve"]
