"""Several threads: of one tree, or of several."""

from __future__ import annotations

from kinolab.search.tree.threads.other_trees import OtherTrees
from kinolab.search.tree.threads.parallel_growth import Growth
from kinolab.search.tree.threads.threaded_tree import ThreadedTree

__all__ = ["Growth", "OtherTrees", "ThreadedTree"]
