"""Compiled tree planners: trees that grow in one compiled loop, for any machine.

Machines are passed as function addresses and problems as arrays, so the kernels are compiled once
for all problems and cached on disk. Nothing is allocated per iteration.
"""

from kinolab.search.tree.compiled_planner import AbstractCompiledPlanner
from kinolab.search.tree.step_work import ITERATION_SECONDS, growth_seconds, step_seconds
from kinolab.search.tree.sub_searches import SubSearch
from kinolab.search.tree.tree_extension import (
    UNBOUNDED_STEPS,
    AbstractTreeExtension,
    SearchState,
    search_state,
)

__all__ = [
    "ITERATION_SECONDS",
    "UNBOUNDED_STEPS",
    "AbstractCompiledPlanner",
    "AbstractTreeExtension",
    "SearchState",
    "SubSearch",
    "growth_seconds",
    "search_state",
    "step_seconds",
]
