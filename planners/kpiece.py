"""KPIECE: interior-exterior cell exploration, by OMPL."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, final

from ompl import control as oc

from kinolab.search import with_default
from kinolab.search.ompl import AbstractGridPlanner, OmplSetup


@final
@dataclass(frozen=True, kw_only=True)
class KPIECE(AbstractGridPlanner):
    """Kinodynamic planning by interior-exterior cell exploration (OMPL).

    Source: Sucan, Kavraki, WAFR 2008.
    """

    name: ClassVar[str] = "kpiece"
    work_per_iteration: ClassVar[float] = 1e-2

    angles: bool = with_default(True, AbstractGridPlanner, "angles")

    def make(self, setup: OmplSetup) -> Any:
        """Return OMPL's planner."""
        return oc.KPIECE1(setup.space_information)
