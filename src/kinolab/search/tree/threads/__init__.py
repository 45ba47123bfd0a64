"""Several threads: of one tree, or of several."""

from __future__ import annotations

from kinolab.search.tree.threads.other_trees import OtherTrees
from kinolab.search.tree.threads.threaded_tree import AbstractThreadedPlanner

__all__ = ["AbstractThreadedPlanner", "OtherTrees"]
