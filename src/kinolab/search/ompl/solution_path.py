"""The solution path of an OMPL planner: its controls, copied and as rows of inputs."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.steering.goal_connection import SteeredGoalConnection


@dataclass(frozen=True)
class SolutionPath:
    """Controls of an OMPL solution path, with their durations in [s]."""

    difference: float  # normalised goal error at its end
    durations: list[float]
    controls: list[list[float]]


def path_in(definition: Any) -> SolutionPath:
    """Copy the path out of OMPL, which frees its states and controls when it is cleared."""
    if not definition.hasSolution():
        return SolutionPath(math.inf, [], [])
    path, size = definition.getSolutionPath(), definition.getSpaceInformation().getControlSpace()
    return copied(path, size.getDimension(), definition.getSolutionDifference())


def copied(path: Any, inputs: int, difference: float) -> SolutionPath:
    """Copy a path of OMPL's whose controls have a number of entries."""
    rows = range(path.getControlCount())
    controls = [[path.getControl(k)[i] for i in range(inputs)] for k in rows]
    return SolutionPath(difference, list(path.getControlDurations()), controls)


def with_last_step(
    path: SolutionPath, problem: PlanningTask, last_step: SteeredGoalConnection | None
) -> SolutionPath:
    """Append the goal connection from the end of OMPL's path, if there is one."""
    inputs = last_step.inputs if last_step else []
    steps = [problem.step] * len(inputs)
    return replace(path, durations=path.durations + steps, controls=path.controls + inputs)


def input_rows(problem: PlanningTask, path: SolutionPath) -> tuple[Any, Any]:
    """Return times (N+1,) in [s] and inputs (N, nu), one row per propagation step."""
    held: list[list[float]] = []
    for duration, values in zip(path.durations, path.controls, strict=True):
        held += [values] * round(duration / problem.step)
    u = np.array(held, dtype=float).reshape(len(held), problem.model.nu)
    return problem.step * np.arange(len(held) + 1), u
