"""Artificial potential fields: attraction to the goal, repulsion from obstacles."""

from kinolab.search.potential.potential_search import FieldSettings, solve

__all__ = ["FieldSettings", "solve"]
