"""What compiled trees hold, for tests that compare them."""

from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray


def contents(growth: Any) -> list[Array]:
    """Return copies of all that the nodes of a tree hold, and of its counts."""
    tree, size = growth.nodes, int(growth.nodes.size[0])
    arrays = (tree.x, tree.u, tree.parent, tree.steps, tree.clearance, tree.failures)
    return [*(array[:size].copy() for array in arrays), tree.rejections.copy()]


def same(one: list[Array], other: list[Array]) -> bool:
    """Say whether two trees hold the same, bit for bit."""
    return all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))
