"""Is a motion one of a problem's machine?"""

from __future__ import annotations

from collections.abc import Iterator

from kinolab.errors import Mistake
from kinolab.problem.task import PlanningTask
from kinolab.trajectory import Trajectory

REMEDY = "Give the problem that it belongs to."


def other_machine(problem: PlanningTask, trajectory: Trajectory) -> Iterator[Mistake]:
    """Yield what tells that a motion is another machine's, nothing where it is the problem's."""
    model = problem.model
    if trajectory.state_names != model.state_names:
        own, names = ", ".join(trajectory.state_names), ", ".join(model.state_names)
        what = f"its states are {own}; those of {problem.machine.name} are {names}."
        yield Mistake("trajectory", what, REMEDY)
    elif trajectory.control_names != model.plant.control_names:
        yield Mistake("trajectory", "its inputs are another machine's.", REMEDY)
