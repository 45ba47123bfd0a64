"""Expansive-space trees (EST), by OMPL."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, final

from ompl import base as ob
from ompl import control as oc

from kinolab.search.ompl import AbstractGridPlanner, OmplSetup


@final
@dataclass(frozen=True, kw_only=True)
class EST(AbstractGridPlanner):
    """Expansive space trees: grow where a grid of cells holds few states (OMPL).

    Source: Hsu, Latombe, Motwani, IJCGA 9(4-5), 1999.
    """

    name: ClassVar[str] = "est"

    def make(self, setup: OmplSetup) -> Any:
        """Return OMPL's planner."""
        setup.space_information.setValidStateSamplerAllocator(_NoSampler)
        return oc.EST(setup.space_information)


class _NoSampler(ob.ValidStateSampler):  # type: ignore[misc]
    """Samples nothing: OMPL would search for a valid target state, which its control ignores."""

    def sample(self, _: Any) -> bool:
        """Report success."""
        return True

    def sampleNear(self, _: Any, _near: Any, _distance: float) -> bool:
        """Report success."""
        return True
