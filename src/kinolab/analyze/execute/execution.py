"""Monte Carlo execution of a plan on perturbed machines."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable
from copy import copy
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from kinolab.analyze.execute.conditions import Conditions
from kinolab.analyze.execute.failure import Failure, FailureCount, FailureGroup, Outcome
from kinolab.analyze.execute.run_monitor import RunMonitor
from kinolab.dynamics import Model
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.errors import InputError, KinolabError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.unwrapping import unwrapped
from kinolab.simulation import ReferenceStep
from kinolab.simulation.dop853 import TOO_SMALL
from kinolab.simulation.reference import REASONS, DivergedError
from kinolab.steering.tracker import LARGE_DEVIATION, Tracker
from kinolab.trajectory import Trajectory

KEPT = 1000  # runs whose paths are kept; of further ones only how they ended
SETTLING_FRACTION = 0.25  # of the plan's duration: how much sooner or later it may reach the goal


@dataclass(frozen=True)
class Deviation:
    """The entry of the state that was farthest from the plan, in its own unit.

    Attributes:
        name: Of the entry.
        amount: How far it was from the plan.
        time: When, in [s].
    """

    name: str
    amount: float
    time: float


@dataclass(frozen=True, eq=False)
class ExecutionRun:
    """One execution of a plan.

    Attributes:
        outcome: ``reached`` the goal; ``missed`` it; ``collided`` before; ``strayed`` from the
            workspace or into a forbidden cone; or ``lost``, if the equations failed along the
            motion.
        x: States, one per step, shape (steps + 1, nx); up to the goal or the fault.
        excess: Smallest goal error around the plan's end, in tolerances of the plan.
        off: Largest deviation of a tracked state's entry from the plan, times its weight, shape
            (steps + 1,).
        parameters: Parameters of the machine, by name.
        steps: Their number.
        failure: Why it failed; None if it reached the goal.
        farthest: Which entry was farthest from the plan.
        wanting: Share of the steps in which the feedback wanted more of an input than there is,
            by the input's name; those that never were are left out.
    """

    outcome: Outcome
    x: Array
    excess: float
    off: Array
    parameters: dict[str, float]
    steps: int
    failure: Failure | None
    farthest: Deviation
    wanting: dict[str, float]

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
        failures: Why they failed, of all, the most frequent reason first.
        worst: Largest deviation from the plan, of all, in the weights of [metric].
        farthest: Which entry that was, and the number of the run, from 0.
    """

    conditions: Conditions
    seed: int
    runs: tuple[ExecutionRun, ...]
    counts: dict[str, int]
    failures: tuple[FailureGroup, ...]
    worst: float
    farthest: tuple[Deviation, int]

    @property
    def total(self) -> int:
        """Number of all runs."""
        return sum(self.counts.values())

    @property
    def reached(self) -> int:
        """Number of runs that reached the goal without colliding or straying."""
        return self.counts.get("reached", 0)


@dataclass(frozen=True, eq=False)
class Motion:
    """How a perturbed machine moves along a plan, whatever it may touch.

    Attributes:
        x: States, one per step, shape (steps + 1, nx).
        t: Their times in [s], shape (steps + 1,).
        nearest: Smallest goal error around the plan's end, in tolerances of the plan.
        failure: Why it does not come to the goal; None if it does.
        wanting: As of ``ExecutionRun``.
    """

    x: Array
    t: Array
    nearest: float
    failure: Failure | None
    wanting: dict[str, float]


class Executor:
    """Executes a plan in closed loop, with tracking gains designed for the nominal machine.

    Every run depends on its number and the seed alone.

    Args:
        conditions: Perturbations of the machine and its sensors.
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
        self.problem, self.conditions, self.seed, self.large = problem, conditions, seed, large
        self.plan = unwrapped(problem, trajectory)
        self.tracker = Tracker.along(problem, self.plan, large=large, asked=conditions.track)
        self.actual = _actual(problem, conditions)
        self.monitor = RunMonitor(self.actual, self.plan.x)
        spans = np.diff(self.plan.t)
        later = math.ceil(SETTLING_FRACTION * self.plan.duration / spans[-1])
        self._first = math.floor((1.0 - SETTLING_FRACTION) * len(spans))
        self._spans = [*spans.tolist(), *[float(spans[-1])] * later]

    def under(self, conditions: Conditions) -> Self:
        """Return the same under other conditions, with the same gains."""
        other = copy(self)
        other.conditions = conditions
        return other

    def tracked_by(self, tracker: Tracker) -> Self:
        """Return the same with other gains."""
        other = copy(self)
        other.tracker = tracker
        return other

    def run(self, k: int) -> ExecutionRun:
        """Return the result of run k, counted from 0; without its path from the 1000th on.

        A perturbed machine steps until the goal is reached around the plan's end, or time runs out.

        Raises:
            InputError: If no machine has such parameters.
        """
        built, motion = self.motion(k)
        fault = self.monitor.first_fault(motion.x, motion.t, built)
        failure = motion.failure if fault is None else fault
        x = motion.x if fault is None else motion.x[: fault.step + 1]
        if failure is not None:
            failure = replace(failure, slip=self.monitor.slip(x[: failure.step + 1], motion.t))
        off, farthest = self._off(x, motion.t)
        outcome: Outcome = "reached" if failure is None else failure.outcome
        parameters, steps = built.parameter_values, len(x) - 1
        made = ExecutionRun(
            outcome, x, motion.nearest, off, parameters, steps, failure, farthest, motion.wanting
        )
        return made if k < KEPT else made.ending

    def motion(self, k: int) -> tuple[Mechanism, Motion]:
        """Return the machine of run k and how it moves, whatever it may touch.

        Raises:
            InputError: If no machine has such parameters.
        """
        generator = np.random.default_rng([self.seed, k])
        built = self.conditions.machine(self.actual.system, generator)
        parameters = built.parameter_values
        step = ReferenceStep(self.actual, parameters)
        states, nearest, best = [self.plan.x[0]], math.inf, 0
        wanting, lost = np.zeros(len(self._inputs)), None
        for i, span in enumerate(self._spans):
            try:
                acting, beyond = self._acting(i, states[-1], generator)
                states.append(step(states[-1], acting, span))
            except KinolabError as error:
                lost = self._lost(error, i)
                break
            wanting += beyond
            if i + 1 >= self._first:
                excess = self.monitor.goal_excess(states[-1], parameters)
                nearest, best = min((nearest, best), (excess, i + 1))
            if nearest <= self.monitor.enough:
                break
        x, t = np.array(states), np.concatenate([[0.0], np.cumsum(self._spans)])[: len(states)]
        failure = lost
        if lost is None and not nearest <= self.monitor.enough:
            best = best or len(x) - 1  # where no error was a number
            failure = self.monitor.missed(x[best], float(t[best]), best, parameters)
        shares = dict(zip(self._inputs, (wanting / len(x)).tolist(), strict=True))
        asked = {name: share for name, share in shares.items() if share}
        return built, Motion(x, t, nearest, failure, asked)

    @property
    def _inputs(self) -> tuple[str, ...]:
        """Names of the plant's inputs, then of the references of its feedback, if any."""
        model = self.problem.whole or self.problem.model
        references = () if model.plant is model else model.control_names
        return (*model.plant.control_names, *references)

    def _lost(self, error: KinolabError, i: int) -> Failure:
        """Return why the motion could not be followed in step i."""
        begun = float(sum(self._spans[:i]))
        within = error.time if isinstance(error, DivergedError) else 0.0
        reason = error.reason if isinstance(error, DivergedError) else str(error)
        cause = reason.partition(" at ")[0].rpartition(": ")[2]  # without the numbers of this run
        if reason == REASONS[TOO_SMALL]:
            cause = "something grows beyond all bounds, or jumps"
        return Failure("lost", cause.rstrip("."), reason.rstrip("."), begun + within, i)

    def _acting(
        self, i: int, x: Array, generator: np.random.Generator
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Return the plant's inputs in step i, (nu,), and which of ``_inputs`` want more."""
        problem, model = self.problem, self.problem.whole or self.problem.model
        seen = self.conditions.measured(problem, x, generator)
        wanted = self.tracker.planned(i)
        if self.conditions.tracked:
            wanted = self.tracker.wanted(i, seen)
        held = self.tracker.limited(wanted)
        acting = model.plant_inputs(seen, held)
        beyond = wanted != held
        if model.plant is not model:  # the law cuts its inputs itself
            lower, upper = model.plant.control_bounds.T
            beyond = np.append((acting <= lower) | (acting >= upper), beyond)
        return self.conditions.disturbed(model.plant, acting, generator), beyond

    def _off(self, x: Array, t: Array) -> tuple[Array, Deviation]:
        """Return the largest weighted deviation of each state from the planned one, and the worst.

        Args:
            x: States, shape (n, nx).
            t: Times in [s], shape (n,) or longer.
        """
        planned, names = self.plan.x, self.problem.model.state_names
        deviations = np.array(
            [
                np.abs(self.tracker.deviation(planned[min(k, len(planned) - 1)], state))
                for k, state in enumerate(x)
            ]
        )
        weighted = deviations * self.tracker.weights
        k, i = np.unravel_index(int(np.argmax(weighted)), weighted.shape)
        return weighted.max(axis=1), Deviation(names[i], float(deviations[k, i]), float(t[k]))

    def tally(
        self, runs: Iterable[ExecutionRun], told: Callable[[int], None] = lambda _: None
    ) -> Execution:
        """Count runs as they come, in their order.

        Args:
            runs: All of them.
            told: Called after each run with the number of runs so far.
        """
        kept: list[ExecutionRun] = []
        counts, failures = Counter[str](), FailureCount()
        worst, farthest = -1.0, (Deviation("", 0.0, 0.0), 0)
        for k, run in enumerate(runs):
            if k < KEPT:
                kept.append(run)
            counts[run.outcome] += 1
            if run.failure is not None:
                failures.add(k, run.failure)
            if run.deviation > worst:
                worst, farthest = run.deviation, (run.farthest, k)
            told(k + 1)
        groups, made = failures.groups, tuple(kept)
        return Execution(self.conditions, self.seed, made, dict(counts), groups, worst, farthest)


def _actual(problem: PlanningTask, conditions: Conditions) -> PlanningTask:
    """Return the problem of the actual machine, whose numbers are parameters where they vary.

    Their values are the planned ones, so that other conditions may take them back.
    """
    varied = conditions.varied(problem.system)
    if len(varied.parameters) == len(problem.model.parameter_names):
        return problem
    planned = problem.system.offered | problem.system.parameter_values
    nominal = varied.with_parameters(**{name: planned[name] for name in varied.parameter_values})
    model = Model(nominal.with_feedback(None))
    return replace(problem, machine=model.machine, model=model, whole=None)
