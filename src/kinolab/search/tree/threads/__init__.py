"""One tree grown by several threads."""

from __future__ import annotations

from kinolab.search.tree.threads.parallel_growth import Growth
from kinolab.search.tree.threads.threaded_tree import ThreadedTree

__all__ = ["Growth", "ThreadedTree"]
