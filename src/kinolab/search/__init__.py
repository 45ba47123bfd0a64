"""Planner interface, search results, and tree, roadmap and potential-field searches."""

from kinolab.lazy import lazy_package
from kinolab.numerics.arrays import Array as Array
from kinolab.search.budget import Budget as Budget
from kinolab.search.planner import AbstractPlanner as AbstractPlanner
from kinolab.search.result import Outcome as Outcome
from kinolab.search.result import SearchResult as SearchResult
from kinolab.search.result import unsolved as unsolved
from kinolab.settings import setting as setting
from kinolab.settings import with_default as with_default

__all__, *_ = lazy_package(__name__, __file__)  # what it imports as itself
