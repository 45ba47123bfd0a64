"""Planner interface, search results, and tree, roadmap and potential-field searches."""

from kinolab.numerics.arrays import Array
from kinolab.search.budget import Budget
from kinolab.search.planner import AbstractPlanner, setting, with_default
from kinolab.search.result import (
    Outcome,
    SearchResult,
    unsolved,
)

__all__ = [
    "AbstractPlanner",
    "Array",
    "Budget",
    "Outcome",
    "SearchResult",
    "setting",
    "unsolved",
    "with_default",
]
