"""Compiled tree planners: trees that grow in one compiled loop, for any machine.

Machines are passed as function addresses and problems as arrays, so the kernels are compiled once
for all problems and cached on disk. Nothing is allocated per iteration.
"""

from kinolab.search.tree.compiled_planner import AbstractCompiledPlanner as AbstractCompiledPlanner
from kinolab.search.tree.growth_work import ITERATION_SECONDS as ITERATION_SECONDS
from kinolab.search.tree.growth_work import growth_seconds as growth_seconds
from kinolab.search.tree.growth_work import step_seconds as step_seconds
from kinolab.search.tree.search_state import SearchState as SearchState
from kinolab.search.tree.search_state import search_state as search_state
from kinolab.search.tree.sub_searches import SubSearch as SubSearch
from kinolab.search.tree.tree_extension import UNBOUNDED_STEPS as UNBOUNDED_STEPS
from kinolab.search.tree.tree_extension import AbstractTreeExtension as AbstractTreeExtension
