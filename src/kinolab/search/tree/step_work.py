"""What the steps of a compiled tree take, for clocks that count work."""

from __future__ import annotations

from kinolab.numerics.work import in_whole_ticks
from kinolab.problem import PlanningTask


def step_seconds(problem: PlanningTask) -> float:
    """Return what a step in a tree takes on an idle computer with all that belongs to it, in [s].

    Fitted to the scenarios that come with kinolab (one core of an AMD EPYC); it holds within a
    factor of two for most, and of four for all of them.
    """
    substeps = problem.scenario.integration.substeps
    evaluations = substeps * (2 if problem.machine.requirements else 1)
    shapes = sum(len(body.shapes) for body in problem.bodies) + len(problem.cables)
    switching = 2e-5 if problem.machine.modes else 0.0  # where every step may end a mode
    seconds = 1e-6 + 6e-9 * problem.model.operations * evaluations + 5e-7 * shapes + switching
    return in_whole_ticks(seconds)  # the sum of steps is the same in whatever parts they are made
