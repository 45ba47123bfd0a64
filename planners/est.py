"""Expansive space trees, by OMPL."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

from ompl import control as oc

from kinolab.bridge import AbstractTreePlanner


@final
@dataclass(frozen=True, kw_only=True)
class EST(AbstractTreePlanner):
    """Expansive space trees: grow where a grid of cells holds few states (OMPL).

    Source: Hsu, Latombe, Motwani, IJCGA 9(4-5), 1999.
    """

    name: ClassVar[str] = "est"

    def make(self, space_information: object) -> object:
        """Return OMPL's planner."""
        return oc.EST(space_information)
