"""Stable Sparse RRT (SST), compiled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

from kinolab.search import setting
from kinolab.search.tree.sampled.sampled_growth import SPARSE, Growth
from kinolab.search.tree.threads import AbstractThreadedPlanner


@final
@dataclass(frozen=True, kw_only=True)
class SST(AbstractThreadedPlanner):
    """Stable Sparse RRT, compiled: one cheapest state per small ball keeps the tree sparse.

    Continues to shorter motions in the same tree, for up to ``improve`` seconds.

    Source: Li, Littlefield, Bekris, IJRR 35(5), 2016.
    """

    compares_costs: ClassVar[bool] = True
    name: ClassVar[str] = "sst"

    selection_radius: float = setting(
        0.2,
        0.0,
        1e6,
        unit="metric",
        meaning="Radius around a sample within which the cheapest state is grown, not the nearest.",
    )
    improving_radius: float = setting(
        1.5,
        0.0,
        1e6,
        unit="metric",
        meaning="The same, once a motion into the goal is known.",
    )
    pruning_radius: float = setting(
        0.1,
        0.0,
        1e6,
        unit="metric",
        meaning="Radius around a state within which only the cheapest one is grown.",
    )

    def growth(self) -> Growth:
        """Return how the tree grows."""
        growth = super().growth()
        return growth._replace(
            kind=SPARSE,
            selection_radius=self.selection_radius,
            improving_radius=self.improving_radius,
            pruning_radius=self.pruning_radius,
        )
