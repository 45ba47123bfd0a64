"""Interface of tree extensions."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.search.graph import SearchGraph
from kinolab.search.tree.tree import ALL_STEPS, Tree

UNBOUNDED_STEPS = 2**62  # more than any motion has


class AbstractTreeExtension(ABC):
    """A tree that grows in compiled code.

    Attributes:
        nodes: The tree.
        best: The node nearest to the goal and its normalised goal error, shape (2,).
    """

    nodes: Tree
    best: Array

    @abstractmethod
    def begin(self) -> None:
        """Clear the tree to its start."""

    @abstractmethod
    def grow(self, iterations: int) -> tuple[int, int]:
        """Grow for some iterations; return GROWING, REACHED or FULL, and the number made."""

    @property
    def steps_made(self) -> int:
        """Steps of the machine that were tried so far."""
        return int(self.nodes.rejections[ALL_STEPS])

    def explored(self) -> SearchGraph:
        """Return a copy of the tree, thinned if it is large."""
        nodes = self.nodes
        own = np.arange(nodes.x.shape[1]) != nodes.cost_entry
        parents = nodes.parent[: int(nodes.size[0])]
        return SearchGraph.of_tree(lambda kept: nodes.x[kept][:, own], parents)

    def shorten(self, steps: int) -> bool:  # noqa: ARG002
        """Search only for motions of fewer steps from now on; return whether any may exist."""
        return False

    def close(self) -> None:  # noqa: B027  most have nothing to end
        """End what grows it; there is no growth afterwards."""
