"""What the growth of a tree takes on an idle computer."""

from __future__ import annotations

from kinolab.dynamics.codegen.methods import METHODS
from kinolab.numerics.work import in_whole_ticks
from kinolab.problem import PlanningTask

ITERATION_SECONDS = 1.5e-6  # [s] of work for an iteration of a tree, its steps apart


def step_seconds(problem: PlanningTask) -> float:
    """Return what a step in a tree takes on an idle computer with all that belongs to it, in [s].

    Fitted to the scenarios that come with kinolab and to dynobench (one core of an AMD EPYC); it
    holds within a factor of two for most, and of four for all of them.
    """
    integration, operations = problem.scenario.integration, problem.model.operations
    method = METHODS[integration.method]
    evaluations = integration.substeps * method.evaluations(problem.model.nx)
    shapes = sum(len(body.shapes) for body in problem.bodies) + len(problem.cables)
    seconds = 4e-7 + operations * (7e-9 + 7e-10 * evaluations) + 1.5e-7 * shapes
    if problem.model.plant is not problem.model:
        seconds += 4e-6  # the law
    if problem.machine.requirements:
        seconds *= 2.0
    if problem.machine.modes:
        seconds += 2e-5  # every step may end a mode
    return in_whole_ticks(seconds)  # the sum of steps is the same in whatever parts they are made


def growth_seconds(each_step: float, steps: int, iterations: int) -> float:
    """Return what the growth of a tree takes on an idle computer, in [s].

    Args:
        each_step: What a step takes, in [s].
        steps, iterations: That were made.
    """
    return steps * each_step + iterations * ITERATION_SECONDS
