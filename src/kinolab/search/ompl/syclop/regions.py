"""Regions of positions, and of nearness to the goal."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.problem.metric import projected_coordinates
from kinolab.search.ompl.goal_errors import GoalErrors


class Regions:
    """A grid of regions, equally many along each axis.

    The first axes are coordinates of the configuration. The last one is the level, which counts how
    often the distance to the goal was halved: 0 is all that is farther away than
        ``goal_region_scale`` times the
    goal's tolerances, and rates count there as well.

    Args:
        problem: Whose states and goal.
        count: About how many regions there are to be.
        goal_region_scale: What counts as near the goal, in its tolerances.
        angles: Whether angles are divided too, where there are fewer than three lengths.

    Attributes:
        entries: Of the state, that are divided.
        cells: Along each axis.
        low: Lowest coordinates, those of the level included.
        high: Highest coordinates.
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
        """Return where a state lies in the grid."""
        shares = self._near.fractions(values)
        level = 1 + math.log2(self._zoom / max(1.0, *map(abs, shares))) if shares else 0.0
        return [*(values[entry] for entry in self.entries), level]

    def reach(self, level: int) -> float:
        """Return how far around the goal a level begins, in tolerances; 1 within the goal."""
        return max(1.0, self._zoom / 2.0 ** (level - 1))

    def far(self) -> Iterator[list[float]]:
        """Yield the middle of every region that is far from the goal."""
        for cell in np.ndindex(*(self.cells,) * len(self.entries)):
            yield self._middle((*cell, 0))

    def empty(self) -> Iterator[list[float]]:
        """Yield the middle of every region without states: its level is near, its position far."""
        for cell in np.ndindex(*(self.cells,) * len(self.low)):
            middle = self._middle(cell)
            if cell[-1] and not self._holds_states(cell[-1], middle):
                yield middle

    def _middle(self, cell: tuple[int, ...]) -> list[float]:
        middle: list[float] = (self.low + (np.array(cell) + 0.5) * self._sizes).tolist()
        return middle

    def _holds_states(self, level: int, middle: list[float]) -> bool:
        if self._zoom < 2.0 ** (level - 1):
            return False  # nothing is nearer to the goal than what is inside it
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
