"""Projection for grid-based planners: over positions, and finer around the goal."""

from __future__ import annotations

import math
from typing import Any

from ompl import base as ob

from kinolab.problem import PlanningTask
from kinolab.problem.metric import CELLS_AROUND_GOAL, projected_coordinates
from kinolab.search.ompl.control_guidance import ControlGuide
from kinolab.search.ompl.goal_errors import GoalErrors
from kinolab.search.ompl.spaces import Layout


class CellProjection(ob.ProjectionEvaluator):  # type: ignore[misc]
    """Projection of a state to cell coordinates, with cells of edge 1.

    Far from the goal, cells divide the first coordinates. Within ``goal_region_scale`` times the
    goal's tolerances they divide everything that the goal constrains, rates included, and halve in
    width with half the distance, so that progress into the goal always reaches new cells. The space
    keeps this object, so it must not refer to the space.

    Args:
        space: OMPL's space of its states.
        cells: Number of cells along each divided coordinate.
        angles: Whether angles are divided, too, if there are fewer than three lengths.
        goal_region_scale: What counts as near the goal, in its tolerances.
        guide: Says in which state's cell a state counts; each in its own without one.
    """

    def __init__(
        self,
        problem: PlanningTask,
        space: Any,
        cells: int,
        angles: bool,
        goal_region_scale: float = 1.0,
        guide: ControlGuide | None = None,
    ) -> None:
        super().__init__(space)
        self._layout, self._guide, self._zoom = Layout(problem), guide, goal_region_scale
        entries = projected_coordinates(problem, angles=angles)
        lower, upper = problem.sampling_bounds[entries].T
        sizes = (upper - lower) / cells
        self._far = list(zip(entries, lower.tolist(), sizes.tolist(), strict=True))
        self._near = GoalErrors(problem, goal_region_scale) if goal_region_scale > 1.0 else None
        named = self._near.size if self._near else 0
        self._across = max(2, round(CELLS_AROUND_GOAL ** (1 / max(1, named))))
        self._dimension = max(len(entries), 1 + named)

    def set_cells(self) -> None:
        """Set the cell sizes; OMPL requires the space to be set up before."""
        self.inferCellSizes()  # allocates them
        for k in range(self._dimension):
            self.setCellSizes(k, 1.0)

    def getDimension(self) -> int:
        """Return the dimension of the projection."""
        return self._dimension

    def project(self, state: Any, projection: Any) -> None:
        """Write the coordinates of a state, in cells."""
        values = self._layout.read(state)
        counted = self._guide.counted(values) if self._guide else values
        coordinates = self._coordinates(counted)
        for k in range(self._dimension):
            projection[k] = coordinates[k] if k < len(coordinates) else 0.0

    def cell(self, values: list[float]) -> tuple[int, ...]:
        """Return the cell of a state."""
        return tuple(map(math.floor, self._coordinates(values)))

    def _coordinates(self, values: list[float]) -> list[float]:
        shares = self._near.fractions(values) if self._near else None
        if not shares:
            return [(values[entry] - lower) / size for entry, lower, size in self._far]
        level = math.floor(math.log2(self._zoom / max(1.0, *map(abs, shares))))
        per_tolerance = self._across / 2 * 2**level / self._zoom
        # first entry below zero: distinct from all cells far from the goal
        return [-0.5 - level, *(per_tolerance * fraction for fraction in shares)]
