"""Regions for Syclop: a grid over positions and goal-distance levels."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.problem.metric import projected_coordinates
from kinolab.search.ompl.goal_errors import GoalErrors


class Regions:
    """A grid of regions, with the same number of cells along each axis.

    The first axes are coordinates of the configuration. The last one is the level, the number of
    times the distance to the goal was halved: level 0 is everything farther than
    ``goal_region_scale`` times the goal's tolerances, which include those of rates.

    Args:
        count: Approximate number of regions.
        goal_region_scale: What counts as near the goal, in its tolerances.
        angles: Whether to divide angles too if there are fewer than three lengths.

    Attributes:
        entries: Divided entries of the state.
        cells: Number of cells along each axis.
        low: Lower bounds of the coordinates, the level included.
        high: Upper bounds of the coordinates.
    """

    def __init__(
        self, problem: PlanningTask, count: int, goal_region_scale: float, *, angles: bool
    ) -> None:
        self._problem, self._zoom, self._near = (
            problem,
            goal_region_scale,
            GoalErrors(problem, goal_region_scale),
        )
        self.entries = projected_coordinates(problem, angles=angles)
        self.cells = max(2, round(count ** (1 / (len(self.entries) + 1))))
        low, high = problem.sampling_bounds[self.entries].T.tolist()
        self.low, self.high = [*low, 0.0], [*high, float(self.cells)]
        self._sizes = (np.array(self.high) - self.low) / self.cells

    def coordinates(self, values: list[float]) -> list[float]:
        """Return the coordinates of a state in the grid."""
        shares = self._near.fractions(values)
        level = 1 + math.log2(self._zoom / max(1.0, *map(abs, shares))) if shares else 0.0
        return [*(values[entry] for entry in self.entries), level]

    def reach(self, level: int) -> float:
        """Return the outer distance of a level, in goal tolerances; 1 within the goal."""
        return max(1.0, self._zoom / 2.0 ** (level - 1))

    def far(self) -> Iterator[list[float]]:
        """Yield the centre of every region of level 0."""
        for cell in np.ndindex(*(self.cells,) * len(self.entries)):
            yield self._middle((*cell, 0))

    def empty(self) -> Iterator[list[float]]:
        """Yield the centre of every empty region: its level is near the goal, its position far."""
        for cell in np.ndindex(*(self.cells,) * len(self.low)):
            middle = self._middle(cell)
            if cell[-1] and not self._holds_states(cell[-1], middle):
                yield middle

    def _middle(self, cell: tuple[int, ...]) -> list[float]:
        middle: list[float] = (self.low + (np.array(cell) + 0.5) * self._sizes).tolist()
        return middle

    def _holds_states(self, level: int, middle: list[float]) -> bool:
        if self._zoom < 2.0 ** (level - 1):
            return False  # beyond the innermost level
        goal = self._problem.goal
        for index, target, tolerance in zip(
            goal.indices, goal.targets, goal.tolerances, strict=True
        ):
            if index in self.entries and not self._problem.circular[index]:
                k = self.entries.index(index)
                apart = abs(middle[k] - target) - self._sizes[k] / 2
                if apart > self.reach(level) * tolerance:
                    return False
        return True
