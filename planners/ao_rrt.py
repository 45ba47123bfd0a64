"""AO-RRT, compiled: trees in state-cost space, restarted below the best duration so far."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

from kinolab.search import setting
from kinolab.search.tree.sampled.sampled_growth import IN_COST_SPACE, Growth
from kinolab.search.tree.sampled.sampled_tree import AbstractSampledPlanner


@final
@dataclass(frozen=True, kw_only=True)
class AORRT(AbstractSampledPlanner):
    """Asymptotically optimal RRT, compiled: each tree stays below the best cost so far.

    The first is the tree of rrt_fast; others follow for up to ``improve`` seconds.

    Source: Hauser, Zhou, IEEE Transactions on Robotics 32(6), 2016.
    """

    compares_costs: ClassVar[bool] = True
    name: ClassVar[str] = "ao_rrt"

    cost_weight: float = setting(
        1.0,
        0.0,
        1e6,
        unit="extents",
        meaning="Distance in cost between start and end of the best motion, in the metric.",
    )

    def growth(self) -> Growth:
        """Return how the tree grows."""
        return super().growth()._replace(kind=IN_COST_SPACE, cost_weight=self.cost_weight)
