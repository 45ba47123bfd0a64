"""What a planner is, what a search gives, and how trees, roadmaps and potentials search."""

from kinolab.search.planner import (
    AbstractPlanner,
    Array,
    Budget,
    Outcome,
    SearchResult,
    setting,
    with_default,
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
