"""Potential fields: down to the goal, with navigation functions and randomised escapes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

from kinolab.potential import FieldSettings, solve
from kinolab.problem import Problem
from kinolab.search import AbstractPlanner, Budget, SearchResult, setting


@final
@dataclass(frozen=True, kw_only=True)
class PotentialField(AbstractPlanner):
    """Potential field: follow it down through the full dynamics, escape from minima at random.

    Source: Khatib, IJRR 5(1), 1986; Barraquand, Latombe, IJRR 10(6), 1991.
    """

    name: ClassVar[str] = "potential_field"

    navigation: bool = setting(True)  # whether ways around obstacles are known, not only distances
    escapes: int = setting(1000, 0)  # random motions out of minima before the search gives up
    pull: float = setting(1.0, 0.0)  # [m/s^2] acceleration asked for where the slope is 1
    damping: float = setting(1.0, 0.0)  # [1/s] rate at which velocities that nothing pulls fade
    repulsion: float = setting(1e-3, 0.0)  # [m^3] gain of the push off obstacles
    influence: float = setting(0.3, 1e-3)  # [m] gap below which obstacles push
    horizon: float = setting(2.0, 0.0)  # [s] after which inputs are judged by where they lead
    draws: int = setting(6, 0, 1000)  # random inputs that are judged besides those of the field
    resolution: float = setting(0.0, 0.0)  # [m] edge of the navigation's cells; 0: from the body
    memory: float = setting(16.0, 0.1)  # [MB] for the cells of one control point; they grow to fit
    berth: float = setting(0.5, 0.0)  # [m] from obstacles that ways keep where there is room
    near: float = setting(3.0, 0.0)  # [m] of way left, below which the last motion is looked for
    patience: float = setting(3.0, 0.0)  # [s] without progress that make a local minimum

    def solve(self, problem: Problem, seed: int, budget: Budget) -> SearchResult:
        """Follow the field until the goal; escape from minima while there are escapes left."""
        settings = FieldSettings(
            **{name: getattr(self, name) for name in FieldSettings.__dataclass_fields__}
        )
        return solve(problem, settings, seed, budget)
