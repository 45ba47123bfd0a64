"""What a planner is, what a search gives, and how trees, roadmaps and potentials search."""

from kinolab.numerics.arrays import Array
from kinolab.search.budget import Budget
from kinolab.search.planner import AbstractPlanner, setting, with_default
from kinolab.search.result import (
    Outcome,
    SearchResult,
)

__all__ = [
    "AbstractPlanner",
    "Array",
    "Budget",
    "Outcome",
    "SearchResult",
    "setting",
    "with_default",
]
