"""Who searches with which settings, and how a search ended."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

PROBLEMS = ("disk", "crane")
OMPL, KINOLAB = "OMPL", "kinolab"
OMPL_PLANNERS = ("RRT", "SST", "KPIECE1", "EST", "PDST")
LIKE = {"rrt_fast": "RRT", "sst": "SST"}  # whose settings can be those of OMPL's
AS_IN_OMPL: dict[str, Any] = {  # its defaults, and those of ompl_cpp/problem.h
    "goal_bias": 0.05,
    "goal_region_scale": 1.0,
    "control_samples": 1,
    "min_steps": 1,
    "max_steps": 20,
    "restart_after": 0,
    "goal_connection_period": 0,
    "selection_radius": 0.2,
    "pruning_radius": 0.1,
}


@dataclass(frozen=True)
class Entrant:
    """A planner with its settings.

    Attributes:
        side: OMPL or kinolab.
        planner: Its name there.
        like: Of OMPL's planner whose settings it has; empty where it has its own.
        threads: That grow its tree.
    """

    side: str
    planner: str
    like: str = ""
    threads: int = 1

    @property
    def settings(self) -> str:
        """Which settings it has, in words."""
        text = f"as OMPL's {self.like}" if self.like else "its own"
        return f"{text}, {self.threads} threads" if self.threads > 1 else text

    def __str__(self) -> str:
        return f"{self.side} {self.planner}" + (f" ({self.settings})" if self.like else "")


@dataclass(frozen=True)
class Run:
    """How one search ended; times are in [s].

    Attributes:
        problem: Its name.
        entrant: Who searched.
        seed: Of the random numbers.
        solved: Whether a motion into the goal was found within the limit.
        cpu, wall: Until the first one; the limit where there is none.
        setup: Time before that, in which the search got everything it needs; of the processor, but
            by the clock where several threads search.
        judging_cpu, judging_wall: Of the verdict at the knots, where the search did not ask FCL.
        at_knots: What is wrong with the motion there, and ...
        between: ... within its steps; empty where nothing is.
        duration: Of the motion.
        nodes: Of the tree.
        propagations: Steps that were tried.
    """

    problem: str
    entrant: Entrant
    seed: int
    solved: bool
    cpu: float
    wall: float
    setup: float
    nodes: int
    propagations: int
    judging_cpu: float = 0.0
    judging_wall: float = 0.0
    at_knots: str = ""
    between: str = ""
    duration: float = 0.0

    @property
    def counts(self) -> bool:
        """Whether its time counts: OMPL, too, looks at the knots alone."""
        return self.solved and not self.at_knots

    def __str__(self) -> str:
        text = f"{self.problem}, {self.entrant}, seed {self.seed}: "
        text += f"{self.cpu + self.judging_cpu:.3f} s" if self.solved else "not solved"
        return text + "".join(f"; {fault}" for fault in (self.at_knots, self.between) if fault)


def entrants(theirs: Sequence[str], ours: Sequence[str], threads: int = 1) -> list[Entrant]:
    """Return everyone, OMPL and kinolab in turn; like against like, and each with its own.

    Args:
        theirs, ours: Names of planners.
        threads: With which those of kinolab that are like OMPL's enter once more, if several.
    """
    left = [Entrant(OMPL, name) for name in theirs]
    alike = [Entrant(KINOLAB, name, LIKE[name]) for name in ours if name in LIKE]
    right = alike + [replace(one, threads=threads) for one in alike if threads > 1]
    right += [Entrant(KINOLAB, name) for name in ours]
    both = max(len(left), len(right))
    return [one for k in range(both) for side in (left, right) for one in side[k : k + 1]]
