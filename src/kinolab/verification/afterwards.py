"""What happens after a plan: does an obstacle that goes on hit the machine, which waits there?"""

from __future__ import annotations

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.problem.static_holding import static_holding
from kinolab.problem.task import HORIZON
from kinolab.trajectory import Trajectory


def hit_while_waiting(problem: PlanningTask, trajectory: Trajectory) -> str | None:
    """Return a sentence about the first obstacle that meets the machine where it has come to rest.

    None where nothing moves, the machine does not rest there, or nothing comes in a minute.

    Args:
        problem: The problem that the motion solves.
        trajectory: The motion.
    """
    end, clocks = trajectory.x[-1], problem.model.clocks
    if not (clocks and problem.rests(end)):
        return None
    held = static_holding(problem, end)
    if held is None or not held.holds:
        return None
    # of the planner's steps: this is a warning, and no proof
    later = np.arange(0.0, HORIZON, problem.step / 4)
    states = np.tile(end, (len(later), 1))
    states[:, clocks] += later[:, None]
    checker = problem.checker()
    k = checker.first_collision(*problem.placement(states))
    if k is None:
        return None
    contact = checker.contacts(*problem.placement(states[k]))[0]
    return (
        f"{contact.obstacle} meets {contact.body} {later[k]:.3g} s after the plan's end, if the "
        "machine waits there."
    )
