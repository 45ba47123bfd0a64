"""RRT, compiled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

from kinolab.search.tree.threads import AbstractThreadedPlanner


@final
@dataclass(frozen=True, kw_only=True)
class RRTFast(AbstractThreadedPlanner):
    """Rapidly-exploring random tree, compiled; of several inputs the one that leads nearest.

    Nodes whose extensions often failed are extended less often.

    Source: LaValle, Kuffner, IJRR 20(5), 2001; Cheng, LaValle, Reducing metric sensitivity in
    randomized trajectory design, IROS 2001, for nodes whose extensions often fail.
    """

    name: ClassVar[str] = "rrt_fast"
