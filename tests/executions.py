"""Plans carried out many times in this process."""

from __future__ import annotations

from typing import Any

from kinolab.analyze.execute.conditions import Conditions
from kinolab.analyze.execute.execution import Execution, Executor
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory


def execute(
    problem: PlanningTask,
    trajectory: Trajectory,
    conditions: Conditions,
    runs: int = 100,
    **options: Any,
) -> Execution:
    """Return what comes of so many runs; options are the executor's."""
    executor = Executor(problem, trajectory, conditions, **options)
    return executor.tally(map(executor.run, range(runs)))
