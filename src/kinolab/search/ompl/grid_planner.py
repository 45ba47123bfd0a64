"""What tree planners have in common that look at OMPL's grid instead of at distances."""

from __future__ import annotations

from dataclasses import dataclass

from kinolab.search.ompl.guided_planner import AbstractGuidedPlanner
from kinolab.search.ompl.projection import CellDivision
from kinolab.search.planner import setting


@dataclass(frozen=True, kw_only=True)
class AbstractGridPlanner(AbstractGuidedPlanner):
    """A tree planner that chooses where to grow by a grid over the first coordinates."""

    cells: int = setting(20, 1, 1000, meaning="Cells along each coordinate that is divided.")
    angles: bool = setting(
        False, meaning="Whether angles are divided too, where there are fewer than three lengths."
    )

    def grid(self) -> CellDivision:
        """Return how the default projection divides a configuration."""
        return CellDivision(cells=self.cells, angles=self.angles)
