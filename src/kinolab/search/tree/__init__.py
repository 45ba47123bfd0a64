"""The compiled planning core: trees that grow in one compiled loop, for any machine.

The machine comes as addresses of its functions and the problem as arrays: what is compiled here is
compiled once and kept on disk, whatever is planned for. Nothing is allocated per iteration.
"""

from kinolab.search.tree.compiled_planner import AbstractCompiledPlanner
from kinolab.search.tree.sub_searches import SubSearch
from kinolab.search.tree.tree_extension import (
    UNBOUNDED_STEPS,
    AbstractTreeExtension,
    SearchState,
    search_state,
)

__all__ = [
    "UNBOUNDED_STEPS",
    "AbstractCompiledPlanner",
    "AbstractTreeExtension",
    "SearchState",
    "SubSearch",
    "search_state",
]
