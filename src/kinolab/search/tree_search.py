"""What all trees of held inputs have in common, whoever grows them: how long, and rounds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from kinolab.search.planner import AbstractPlanner, setting


@dataclass(frozen=True, kw_only=True)
class AbstractTreeSearch(AbstractPlanner):
    """A planner that grows a tree from the start by inputs that are held."""

    min_steps: int = setting(
        1,
        1,
        100_000,
        unit="steps",
        meaning="For how many steps of the integration an input is held at least.",
    )
    max_steps: int = setting(
        20,
        1,
        100_000,
        unit="steps",
        meaning="For how many steps of the integration an input is held at most.",
    )
    goal_region_scale: float = setting(
        1.0, 1.0, 1e6, unit="tolerances", meaning="How far around the goal growth aims."
    )
    restart_after: int = setting(
        20_000,
        0,
        unit="iterations",
        meaning="When a new tree begins, each lasting 1.5 times as long; 0 for a single one.",
    )

    def conflicts(self) -> Iterator[tuple[str, str, str]]:
        """Yield steps that exclude each other."""
        if self.min_steps > self.max_steps:
            what = f"{self.min_steps} is more than max_steps, {self.max_steps}."
            yield "min_steps", what, "Lower it, or raise max_steps."
