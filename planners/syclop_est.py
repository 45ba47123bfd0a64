"""Syclop with an expansive-space tree (EST), by OMPL."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, final

from ompl import control as oc

from kinolab.search.ompl import AbstractSyclopPlanner, OmplSetup


@final
@dataclass(frozen=True, kw_only=True)
class SyclopEST(AbstractSyclopPlanner):
    """Syclop: paths through a grid of regions guide an expansive space tree (OMPL).

    Source: Plaku, Kavraki, Vardi, IEEE Transactions on Robotics 26(3), 2010.
    """

    name: ClassVar[str] = "syclop_est"

    def make(self, setup: OmplSetup) -> Any:
        """Return OMPL's planner."""
        return oc.SyclopEST(setup.space_information, self.decomposition(setup))
