"""What a tree is told of motions that are known already."""

from __future__ import annotations

from typing import Any

import pytest

from kinolab.search import Budget
from kinolab.search.tree.incumbent_improvement import IncumbentImprovement


class Bounded:
    """A tree as far as a bound concerns it."""

    def __init__(self) -> None:
        self.most: list[int] = []

    def shorten(self, steps: int) -> bool:
        self.most.append(steps)
        return True


def bounds(budget: Budget, seconds: float) -> list[int]:
    tree: Any = Bounded()
    IncumbentImprovement(tree, budget, seconds, 0.1)
    return list(tree.most)


def test_a_tree_is_bounded_from_its_beginning_where_a_motion_is_known() -> None:
    """One of 2 s in steps of 0.1 s has 20."""
    assert bounds(Budget(10.0, below=2.0), 5.0) == [20]


@pytest.mark.parametrize(("below", "seconds"), [(float("inf"), 5.0), (2.0, 0.0)])
def test_it_is_free_where_none_is_known_or_it_does_not_improve(
    below: float, seconds: float
) -> None:
    assert bounds(Budget(10.0, below=below), seconds) == []
