"""The grid of planners that look at one: over positions, and finer around the goal."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ompl import base as ob

from kinolab.problem import PlanningTask
from kinolab.problem.metric import CELLS_AROUND_GOAL, projected_coordinates
from kinolab.search.ompl.control_guidance import ControlGuide
from kinolab.search.ompl.goal_errors import GoalErrors
from kinolab.search.ompl.spaces import Layout


@dataclass(frozen=True, kw_only=True)
class CellDivision:
    """How a configuration is divided into cells.

    Attributes:
        cells: Along each coordinate that is divided.
        angles: Whether angles are divided too, where there are fewer than three lengths.
    """

    cells: int = 20
    angles: bool = True


class CellProjection(ob.ProjectionEvaluator):  # type: ignore[misc]
    """A state as the cell that it lies in, all of edge 1.

    Far from the goal these are cells of the first coordinates. Within ``goal_region_scale`` times
    the goal's tolerances they are cells of everything that the goal names, rates included, and half
    as wide
    at half the distance: all that is on the way in has a cell of its own.
    The space keeps this object, so that it must not refer to the space.
    """

    def __init__(
        self,
        problem: PlanningTask,
        space: Any,
        grid: CellDivision,
        goal_region_scale: float = 1.0,
        guide: ControlGuide | None = None,
    ) -> None:
        super().__init__(space)
        self._layout, self._guide, self._zoom = Layout(problem), guide, goal_region_scale
        entries = projected_coordinates(problem, angles=grid.angles)
        lower, upper = problem.sampling_bounds[entries].T
        sizes = (upper - lower) / grid.cells
        self._far = list(zip(entries, lower.tolist(), sizes.tolist(), strict=True))
        self._near = GoalErrors(problem, goal_region_scale) if goal_region_scale > 1.0 else None
        named = self._near.size if self._near else 0
        self._across = max(2, round(CELLS_AROUND_GOAL ** (1 / max(1, named))))
        self._dimension = max(len(entries), 1 + named)

    def set_cells(self) -> None:
        """Set the size of the cells; OMPL wants the space to be set up before."""
        self.inferCellSizes()  # makes room for them
        for k in range(self._dimension):
            self.setCellSizes(k, 1.0)

    def getDimension(self) -> int:
        """Return how many coordinates a cell has."""
        return self._dimension

    def project(self, state: Any, projection: Any) -> None:
        """Write the coordinates of a state, counted in cells."""
        values = self._layout.read(state)
        counted = self._guide.counted(values) if self._guide else values
        coordinates = self._coordinates(counted)
        for k in range(self._dimension):
            projection[k] = coordinates[k] if k < len(coordinates) else 0.0

    def cell(self, values: list[float]) -> tuple[int, ...]:
        """Return the cell that a state lies in."""
        return tuple(map(math.floor, self._coordinates(values)))

    def _coordinates(self, values: list[float]) -> list[float]:
        shares = self._near.fractions(values) if self._near else None
        if not shares:
            return [(values[entry] - lower) / size for entry, lower, size in self._far]
        level = math.floor(math.log2(self._zoom / max(1.0, *map(abs, shares))))
        per_tolerance = self._across / 2 * 2**level / self._zoom
        # first below zero
        return [-0.5 - level, *(per_tolerance * fraction for fraction in shares)]
