"""What to try where nothing was found that keeps a machine from its goal."""

from __future__ import annotations

import math

from kinolab.planners.auto import MEMBERS, Auto
from kinolab.problem import PlanningTask
from kinolab.solve import PlanResult

LONGER = 4  # times as long as the search that failed


def next_search_sentence(problem: PlanningTask, plan: PlanResult) -> str:
    """Return which longer search, and which other planner, would be worth trying.

    Args:
        problem: The problem.
        plan: Result of the search that failed.
    """
    section, seconds = problem.scenario.planner, plan.timings.get("search", 0.0)
    longer = f"--time-limit {math.ceil(LONGER * max(section.time_limit, seconds))}"
    most = section.max_iterations
    if most is not None and plan.iterations >= most:
        longer += f" --max-iterations {LONGER * most}"
    members = [member.name for member in MEMBERS]
    other = f"--planner {Auto.name}, in which {' and '.join(members)} take turns with shooting"
    if plan.planner == Auto.name:
        other = f"--planner {' or '.join(members)}, which then has all of the time"
    return (
        f"Nothing that was looked at rules a plan out: search longer than {seconds:.2g} s "
        f"({longer}), or with another planner ({other})."
    )
