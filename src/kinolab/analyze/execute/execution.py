"""A plan carried out many times, each time by a machine that is a little different."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from kinolab.analyze.execute.collision_monitor import CollisionMonitor, Fault
from kinolab.analyze.execute.conditions import Conditions
from kinolab.analyze.execute.tracker import LARGE_DEVIATION, Tracker
from kinolab.errors import InputError, KinolabError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.unwrapping import unwrapped
from kinolab.simulation import ReferenceStep
from kinolab.trajectory import Trajectory

Outcome: TypeAlias = Literal["reached", "missed", "lost"] | Fault

SETTLING_FRACTION = 0.25  # of the plan's duration: how much sooner or later it may reach the goal


@dataclass(frozen=True, eq=False)
class ExecutionRun:
    """One time that a plan was carried out.

    Attributes:
        outcome: ``reached`` the goal; ``missed`` it; ``collided`` before; ``strayed`` from the
            workspace or into a forbidden cone; or ``lost``, where the motion left what the
            equations describe.
        x: States, one per step, shape (steps + 1, nx); up to the goal or what ended it.
        excess: How far outside the goal it came nearest around the plan's end, in tolerances
            of the plan.
        off: Largest distance of a state's entry from the plan, weighted, shape (steps + 1,).
        parameters: Of the machine, by name.
    """

    outcome: Outcome
    x: Array
    excess: float
    off: Array
    parameters: dict[str, float]

    @property
    def deviation(self) -> float:
        """Largest distance from the plan, in the weights of [metric]."""
        return float(self.off.max())


@dataclass(frozen=True, eq=False)
class Execution:
    """Many times that a plan was carried out.

    Attributes:
        conditions: What was wrong with the machine and its sensors.
        seed: Of the random numbers.
        runs: What came of each.
    """

    conditions: Conditions
    seed: int
    runs: tuple[ExecutionRun, ...]

    @property
    def counts(self) -> dict[str, int]:
        """How often it ended in which way."""
        return dict(Counter(run.outcome for run in self.runs))

    @property
    def reached(self) -> int:
        """How often it reached the goal without touching anything or straying."""
        return self.counts.get("reached", 0)


def execute(
    problem: PlanningTask,
    trajectory: Trajectory,
    conditions: Conditions,
    *,
    runs: int = 100,
    seed: int = 1,
    large: float = LARGE_DEVIATION,
    told: Callable[[int], None] = lambda _: None,
) -> Execution:
    """Carry out a plan in closed loop, with gains along it that know the nominal machine.

    The same seed gives the same machines, noise and disturbances.

    Args:
        problem: Whose plan it is.
        trajectory: The plan.
        conditions: What is wrong with the machine and its sensors.
        runs: How often.
        seed: Of the random numbers.
        large: The deviation that gains along the plan answer with a quarter of the inputs' range,
            as a share of what the metric calls large; less makes them stiffer.
        told: Is called with the number of runs made, after each.

    Raises:
        InputError: If the plan has no steps, or the machine is not built with such parameters.
    """
    if not len(trajectory.u):
        raise InputError([Mistake("trajectory", "it has no steps.", "Give a plan that moves.")])
    trajectory = unwrapped(problem, trajectory)
    tracker, surveillance = (
        Tracker.along(problem, trajectory, large=large),
        CollisionMonitor(problem),
    )
    made = []
    for k in range(runs):
        generator = np.random.default_rng([seed, k])
        run = _Run(problem, trajectory, tracker, surveillance, conditions, generator)
        made.append(run.result())
        told(k + 1)
    return Execution(conditions, seed, tuple(made))


class _Run:
    """One machine that follows a plan."""

    def __init__(
        self,
        problem: PlanningTask,
        trajectory: Trajectory,
        tracker: Tracker,
        surveillance: CollisionMonitor,
        conditions: Conditions,
        generator: np.random.Generator,
    ) -> None:
        self._problem, self._plan, self._tracker = problem, trajectory, tracker
        self._model, self._surveillance = problem.whole or problem.model, surveillance
        self._conditions, self._generator = conditions, generator
        self._built = conditions.machine(problem.system, generator)
        self._parameters = self._built.parameter_values
        self._step = ReferenceStep(problem, self._parameters)
        spans = np.diff(trajectory.t)
        later = math.ceil(SETTLING_FRACTION * trajectory.duration / spans[-1])
        self._enough = 1.0 / (1.0 - problem.scenario.goal.reserve)
        self._first = math.floor((1.0 - SETTLING_FRACTION) * len(spans))
        self._spans = [*spans.tolist(), *[float(spans[-1])] * later]

    def result(self) -> ExecutionRun:
        """Move until the goal is reached around the plan's end, or it is too late."""
        states, nearest = [self._plan.x[0]], math.inf
        outcome: Outcome = "missed"
        try:
            for k, span in enumerate(self._spans):
                states.append(self._moved(k, states[-1], span))
                if k + 1 >= self._first:
                    excess = self._surveillance.goal_excess(states[-1], self._parameters)
                    nearest = min(nearest, excess)
                if nearest <= self._enough:
                    outcome = "reached"
                    break
        except KinolabError:
            outcome = "lost"
        x = np.array(states)
        fault = self._surveillance.first_fault(x, self._built)
        if fault is not None:
            last, outcome = fault
            x = x[: last + 1]
        return ExecutionRun(outcome, x, nearest, self._off(x), self._parameters)

    def _moved(self, k: int, x: Array, span: float) -> Array:
        """Return the state after a step of the machine as it is, its controller believing else."""
        problem, model = self._problem, self._model
        seen = self._conditions.measured(problem, x, self._generator)
        wanted = (
            self._tracker.inputs(k, seen) if self._conditions.tracked else self._tracker.planned(k)
        )
        acting = model.plant_inputs(seen, wanted)
        held = self._conditions.disturbed(model.plant, acting, self._generator)
        return self._step(x, held, span)

    def _off(self, x: Array) -> Array:
        planned = self._plan.x
        deviations = [
            np.abs(self._tracker.deviation(planned[min(k, len(planned) - 1)], state))
            for k, state in enumerate(x)
        ]
        off: Array = (np.array(deviations) * self._problem.weights).max(axis=1)
        return off
