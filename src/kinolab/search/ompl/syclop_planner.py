"""Base class of the Syclop planners."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ompl import base as ob

from kinolab.search.ompl.decomposition import FREE_VOLUME_DRAWS, Decomposition
from kinolab.search.ompl.regions import Regions
from kinolab.search.ompl.simple_setup import OmplSetup
from kinolab.search.ompl.tree_planner import AbstractGridPlanner, AbstractGuidedPlanner
from kinolab.settings import setting, with_default


@dataclass(frozen=True, kw_only=True)
class AbstractSyclopPlanner(AbstractGuidedPlanner):
    """A planner that computes a lead through regions and grows its tree along it.

    The wheel exposes none of Syclop's parameters: extensions per lead, probability of abandoning a
    lead early, probability of the shortest lead, further edge costs. It checks the termination
    condition about three times per extension, so an extension counts as three iterations.
    """

    restart_after: int = with_default(100_000, AbstractGuidedPlanner, "restart_after")
    regions: int = setting(
        1000, 1, 10_000, meaning="About how many regions there are, equally many along each axis."
    )
    angles: bool = with_default(False, AbstractGridPlanner, "angles")
    free_volume_samples: int = setting(
        5000,
        0,
        FREE_VOLUME_DRAWS // 4,
        meaning="Random states that estimate how free the regions are.",
    )
    max_states_per_cell: int = setting(
        20,
        1,
        unit="states",
        meaning="Most states per cell that guide the search; cells are finer than regions.",
    )

    def decomposition(self, setup: OmplSetup) -> Decomposition:
        """Return the grid of regions."""
        return Decomposition(
            setup,
            Regions(setup.problem, self.regions, self.goal_region_scale, angles=self.angles),
            samples=self.free_volume_samples,
            max_states_per_cell=self.max_states_per_cell,
            seed=setup.seed,
        )

    def begin(self, setup: OmplSetup) -> Any:
        """Return OMPL's planner after its free-volume estimate, which cannot be interrupted."""
        planner = super().begin(setup)
        planner.solve(ob.PlannerTerminationCondition(lambda: True))
        return planner

    def again(self, setup: OmplSetup, planner: Any) -> Any:  # noqa: ARG002
        """Return a new planner: the graph of regions grows when OMPL clears one."""
        return self.begin(setup)
