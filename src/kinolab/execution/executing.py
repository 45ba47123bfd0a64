"""A plan carried out many times, each time by a machine that is a little different."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.errors import InputError, KinolabError, Mistake
from kinolab.execution.conditions import Conditions
from kinolab.execution.tracking import Tracker
from kinolab.problem import Problem
from kinolab.trajectory import Trajectory
from kinolab.world import CollisionChecker

Array: TypeAlias = NDArray[np.float64]
Outcome: TypeAlias = Literal["reached", "missed", "collided", "lost"]

SETTLE = 0.25  # of the plan's duration: how much sooner or later it may reach the goal


@dataclass(frozen=True, eq=False)
class Executed:
    """One time that a plan was carried out.

    Attributes:
        outcome: ``reached`` the goal; ``missed`` it; ``collided`` before; or ``lost``, where the
            motion left what the equations describe.
        x: States, one per step, shape (steps + 1, nx); up to the goal or the collision.
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
    runs: tuple[Executed, ...]

    @property
    def counts(self) -> dict[str, int]:
        """How often it ended in which way."""
        return dict(Counter(run.outcome for run in self.runs))

    @property
    def reached(self) -> int:
        """How often it reached the goal without touching anything."""
        return self.counts.get("reached", 0)


def execute(
    problem: Problem,
    trajectory: Trajectory,
    conditions: Conditions,
    *,
    runs: int = 100,
    seed: int = 1,
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
        told: Is called with the number of runs made, after each.

    Raises:
        InputError: If the plan has no steps.
    """
    if not len(trajectory.u):
        raise InputError([Mistake("trajectory", "it has no steps.", "Give a plan that moves.")])
    tracker, made = Tracker.along(problem, trajectory), []
    for k in range(runs):
        generator = np.random.default_rng([seed, k])
        made.append(_Run(problem, trajectory, tracker, conditions, generator).result())
        told(k + 1)
    return Execution(conditions, seed, tuple(made))


class _Run:
    """One machine that follows a plan."""

    def __init__(
        self,
        problem: Problem,
        trajectory: Trajectory,
        tracker: Tracker,
        conditions: Conditions,
        generator: np.random.Generator,
    ) -> None:
        self._problem, self._plan, self._tracker = problem, trajectory, tracker
        self._model = problem.whole or problem.model
        self._conditions, self._generator = conditions, generator
        self._parameters = conditions.machine(self._model, generator)
        spans = np.diff(trajectory.t)
        later = math.ceil(SETTLE * trajectory.duration / spans[-1])
        self._enough = 1.0 / (1.0 - problem.scenario.goal.reserve)
        self._first = math.floor((1.0 - SETTLE) * len(spans))
        self._spans = [*spans.tolist(), *[float(spans[-1])] * later]

    def result(self) -> Executed:
        """Move until the goal is reached around the plan's end, or it is too late."""
        states, outcome, nearest = [self._plan.x[0]], "missed", math.inf
        try:
            for k, span in enumerate(self._spans):
                states.append(self._moved(k, states[-1], span))
                if k + 1 >= self._first:
                    nearest = min(nearest, self._problem.goal_excess(states[-1]))
                if nearest <= self._enough:
                    outcome = "reached"
                    break
        except KinolabError:
            outcome = "lost"
        x = np.array(states)
        hit = self._first_collision(x)
        if hit is not None:
            outcome, x = "collided", x[: hit + 1]
        return Executed(outcome, x, nearest, self._off(x), self._parameters)  # type: ignore[arg-type]

    def _moved(self, k: int, x: Array, span: float) -> Array:
        """Return the state after a step of the machine as it is, its controller believing else."""
        problem, model = self._problem, self._model
        seen = self._conditions.measured(problem, x, self._generator)
        acting = model.acting(seen, self._tracker.inputs(k, seen))
        held = self._conditions.disturbed(model.plant, acting, self._generator)
        settings = problem.scenario.integration
        after = model.plant.step(
            x, held, span, method=settings.method, substeps=settings.substeps, **self._parameters
        )
        if not np.isfinite(after).all():
            raise KinolabError("the motion is not finite")
        return after

    def _first_collision(self, x: Array) -> int | None:
        problem, model = self._problem, self._problem.model
        if self._parameters != problem.system.parameter_values:
            system = problem.system.with_parameters(**self._parameters)
            problem = replace(problem, system=system)  # a wheel may be larger, too
        ends = model.cables(x, **self._parameters) if problem.cables else None
        frames = model.frames(x, **self._parameters)
        return self._checker(problem).first_collision(frames, ends)

    def _checker(self, problem: Problem) -> CollisionChecker:
        """Return what tells contact with the machine as it is; the world's clearance is no part."""
        world = replace(problem.world, clearance=0.0)
        pairs = problem.system.collisions
        return CollisionChecker(problem.bodies, world, cables=problem.cables, self_pairs=pairs)

    def _off(self, x: Array) -> Array:
        planned = self._plan.x
        deviations = [
            np.abs(self._tracker.deviation(planned[min(k, len(planned) - 1)], state))
            for k, state in enumerate(x)
        ]
        off: Array = (np.array(deviations) * self._problem.weights).max(axis=1)
        return off
