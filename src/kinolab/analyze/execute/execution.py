"""Monte Carlo execution of a plan on perturbed machines, and checks of their collisions."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from kinolab.analyze.execute.conditions import Conditions
from kinolab.analyze.execute.tracker import LARGE_DEVIATION, Tracker
from kinolab.dynamics import Model
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.machine_facts import facts_of
from kinolab.errors import InputError, KinolabError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.unwrapping import unwrapped
from kinolab.simulation import ReferenceStep
from kinolab.trajectory import Trajectory

Fault: TypeAlias = Literal["collided", "strayed"]
Outcome: TypeAlias = Literal["reached", "missed", "lost"] | Fault

KEPT = 1000  # runs whose paths are kept; of further ones only how they ended
SETTLING_FRACTION = 0.25  # of the plan's duration: how much sooner or later it may reach the goal


@dataclass(frozen=True, eq=False)
class ExecutionRun:
    """One execution of a plan.

    Attributes:
        outcome: ``reached`` the goal; ``missed`` it; ``collided`` before; ``strayed`` from the
            workspace or into a forbidden cone; or ``lost``, if the equations failed along the
            motion.
        x: States, one per step, shape (steps + 1, nx); up to the goal or the fault.
        excess: Smallest goal error around the plan's end, in tolerances of the plan.
        off: Largest weighted deviation of a state's entry from the plan, shape (steps + 1,).
        parameters: Parameters of the machine, by name.
        steps: Their number.
    """

    outcome: Outcome
    x: Array
    excess: float
    off: Array
    parameters: dict[str, float]
    steps: int

    @property
    def deviation(self) -> float:
        """Largest deviation from the plan, in the weights of [metric]."""
        return float(self.off.max())

    @property
    def ending(self) -> ExecutionRun:
        """The same without its path: the last state, and the largest deviation."""
        return replace(self, x=self.x[-1:], off=self.off.max(keepdims=True))


@dataclass(frozen=True, eq=False)
class Execution:
    """Many executions of a plan.

    Attributes:
        conditions: Perturbations of the machine and its sensors.
        seed: Random seed.
        runs: Results of the first 1000.
        counts: Number of runs by outcome, of all.
        worst: Largest deviation from the plan, of all, in the weights of [metric].
    """

    conditions: Conditions
    seed: int
    runs: tuple[ExecutionRun, ...]
    counts: dict[str, int]
    worst: float

    @property
    def total(self) -> int:
        """Number of all runs."""
        return sum(self.counts.values())

    @property
    def reached(self) -> int:
        """Number of runs that reached the goal without colliding or straying."""
        return self.counts.get("reached", 0)


class Executor:
    """Executes a plan in closed loop, with tracking gains designed for the nominal machine.

    Every run depends on its number and the seed alone.

    Args:
        problem: The problem of the plan.
        trajectory: The plan.
        conditions: Perturbations of the machine and its sensors.
        seed: Random seed.
        large: Deviation that the gains answer with a quarter of the inputs' range, as a fraction of
            one over each state's weight in the metric; smaller is stiffer.

    Raises:
        InputError: If the plan has no steps, or the machine nothing that the conditions vary.
    """

    def __init__(
        self,
        problem: PlanningTask,
        trajectory: Trajectory,
        conditions: Conditions,
        *,
        seed: int = 1,
        large: float = LARGE_DEVIATION,
    ) -> None:
        if not len(trajectory.u):
            raise InputError([Mistake("trajectory", "it has no steps.", "Give a plan that moves.")])
        conditions.require_something_to_vary(problem)
        self._problem, self._conditions, self._seed = problem, conditions, seed
        self._plan = unwrapped(problem, trajectory)
        self._tracker = Tracker.along(problem, self._plan, large=large)
        self._actual = _actual(problem, conditions)
        self._surveillance = CollisionMonitor(self._actual)
        spans = np.diff(self._plan.t)
        later = math.ceil(SETTLING_FRACTION * self._plan.duration / spans[-1])
        self._enough = 1.0 / (1.0 - problem.scenario.goal.reserve)
        self._first = math.floor((1.0 - SETTLING_FRACTION) * len(spans))
        self._spans = [*spans.tolist(), *[float(spans[-1])] * later]

    def run(self, k: int) -> ExecutionRun:
        """Return the result of run k, counted from 0; without its path from the 1000th on.

        A perturbed machine steps until the goal is reached around the plan's end, or time runs out.

        Raises:
            InputError: If no machine has such parameters.
        """
        generator = np.random.default_rng([self._seed, k])
        built = self._conditions.machine(self._actual.system, generator)
        parameters = built.parameter_values
        step = ReferenceStep(self._actual, parameters)
        states, nearest = [self._plan.x[0]], math.inf
        outcome: Outcome = "missed"
        try:
            for i, span in enumerate(self._spans):
                states.append(step(states[-1], self._acting(i, states[-1], generator), span))
                if i + 1 >= self._first:
                    excess = self._surveillance.goal_excess(states[-1], parameters)
                    nearest = min(nearest, excess)
                if nearest <= self._enough:
                    outcome = "reached"
                    break
        except KinolabError:
            outcome = "lost"
        x = np.array(states)
        fault = self._surveillance.first_fault(x, built)
        if fault is not None:
            last, outcome = fault
            x = x[: last + 1]
        made = ExecutionRun(outcome, x, nearest, self._off(x), parameters, len(x) - 1)
        return made if k < KEPT else made.ending

    def _acting(self, i: int, x: Array, generator: np.random.Generator) -> Array:
        """Return the plant's inputs in step i, which the nominal controller finds at a state."""
        problem, model = self._problem, self._problem.whole or self._problem.model
        seen = self._conditions.measured(problem, x, generator)
        tracked = self._conditions.tracked
        wanted = self._tracker.inputs(i, seen) if tracked else self._tracker.planned(i)
        acting = model.plant_inputs(seen, wanted)
        return self._conditions.disturbed(model.plant, acting, generator)

    def _off(self, x: Array) -> Array:
        """Return the largest weighted deviation of each state from the planned one, (n,)."""
        planned = self._plan.x
        deviations = [
            np.abs(self._tracker.deviation(planned[min(k, len(planned) - 1)], state))
            for k, state in enumerate(x)
        ]
        off: Array = (np.array(deviations) * self._problem.weights).max(axis=1)
        return off

    def tally(
        self, runs: Iterable[ExecutionRun], told: Callable[[int], None] = lambda _: None
    ) -> Execution:
        """Count runs as they come, in their order.

        Args:
            runs: All of them.
            told: Called after each run with the number of runs so far.
        """
        kept: list[ExecutionRun] = []
        counts, worst = Counter[str](), 0.0
        for k, run in enumerate(runs):
            if k < KEPT:
                kept.append(run)
            counts[run.outcome] += 1
            worst = max(worst, run.deviation)
            told(k + 1)
        return Execution(self._conditions, self._seed, tuple(kept), dict(counts), worst)


def _actual(problem: PlanningTask, conditions: Conditions) -> PlanningTask:
    """Return the problem of the actual machine, whose numbers are parameters where they vary."""
    varied = conditions.varied(problem.system)
    if len(varied.parameters) == len(problem.model.parameter_names):
        return problem
    model = Model(varied.with_feedback(None))
    return replace(problem, machine=model.machine, model=model, whole=None)


class CollisionMonitor:
    """Checks motions of machines with other parameters in the world of a problem.

    A plan's margins to obstacles and cones are its reserve; here they are not added.

    Args:
        problem: The problem of the plan.
    """

    def __init__(self, problem: PlanningTask) -> None:
        world = replace(problem.world, clearance=0.0)
        cones = tuple(cone.forbidden for cone in problem.keep_outs)
        self._problem = replace(problem, world=world, keep_outs=cones)

    def first_fault(self, x: Array, built: Mechanism) -> tuple[int, Fault] | None:
        """Return the index of the first faulty state and its fault; None if there is none.

        Args:
            x: States, shape (N, nx).
            built: The actual machine.
        """
        problem, model = self._as_built(built), self._problem.model
        parameters = built.parameter_values
        frames = model.frames(x, **parameters)
        ends = model.cables(x, **parameters) if problem.cables else None
        hit = problem.checker().first_collision(frames, ends)
        for k in range(len(x) if hit is None else hit):
            if any(True for _ in problem.outside_world(frames[k])):
                return k, "strayed"
        return None if hit is None else (hit, "collided")

    def goal_excess(self, x: Array, parameters: dict[str, float]) -> float:
        """Return the goal error at a state (nx,), in tolerances of the plan."""
        goal, model = self._problem.goal, self._problem.model
        return goal.excess(x, model.frames(x, **parameters) if goal.needs_frames else None)

    def _as_built(self, system: Mechanism) -> PlanningTask:
        """Return the problem of the actual machine: its shapes may depend on parameters.

        If they do not, it is the same one, whose mesh search trees exist already.
        """
        built = replace(self._problem, machine=facts_of(system))
        same = built.bodies == self._problem.bodies and built.cables == self._problem.cables
        return self._problem if same else built
