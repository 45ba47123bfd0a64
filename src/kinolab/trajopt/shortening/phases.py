"""Machines that switch: a motion is shortened as a sequence of phases with free durations.

Source: Betts, Practical Methods for Optimal Control and Estimation Using Nonlinear Programming, 2nd
ed., 2010, section 4.6.2 (multiple phases); Kelly, An introduction to trajectory optimization, SIAM
Review 59(4), 2017, section 9.4 (hybrid systems).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, islice

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.time_steps import covering_steps
from kinolab.simulation.sensitivities import StepSensitivities
from kinolab.steering.cyclic_coordinates import cyclic_coordinates
from kinolab.trajectory import Trajectory
from kinolab.trajopt.nlp.decision import Knots, Phases, resampled
from kinolab.trajopt.nlp.dynamics_constraint import (
    is_discrete,
    refined,
    step_map,
    true_trajectory,
)
from kinolab.trajopt.nlp.feasibility_check import excess_between_knots, satisfies_all
from kinolab.trajopt.nlp.options import LOOSE, NLP, SHORT, SQP, TIGHT, StoppingTolerances
from kinolab.trajopt.nlp.problem import (
    Minimised,
    TrajectoryProblem,
    most_time,
    nobody_asks,
    usual_room,
)
from kinolab.trajopt.sqp.minimum_cost import minimize_cost
from kinolab.trajopt.sqp.restoration import restore_feasibility


def shortened_phases(
    problem: PlanningTask,
    phases: Sequence[Phase],
    spent: Callable[[], float],
    minimised: Minimised = nobody_asks,
) -> Iterator[Trajectory]:
    """Yield motions that take, or cost, less and less, with the same transitions or fewer.

    Cycles of modes are left out as long as that leaves a motion: fewer phases are also optimised
    in less time. What is left is optimised first, and then, while that is minimised, what had more.

    Args:
        problem: The problem that the motion solves.
        phases: Of the motion.
        spent: Returns the fraction of the budget spent; called before each subproblem.
        minimised: As in ``TrajectoryProblem``.
    """
    if is_discrete(problem):
        return  # the length of its steps is fixed
    task = TrajectoryProblem(
        problem, SHORT.coarse_clearance, room=usual_room(problem),
        cancelled=lambda: spent() >= 1.0, minimised=minimised,
    )  # fmt: skip
    few = task.sampled(SHORT.phase_samples)
    guessing, few = (few.until(partial(_over, spent, most)) for most in SHORT.phase_budgets)
    best: Knots | None = None
    price, last, failures = problem.cost_of, math.inf, 0
    for guess in reversed(_ever_fewer(guessing, phases)):
        fast = _faster(few, guess, LOOSE)
        shorter = fast is not None and (best is None or price(fast) < price(best))
        motion = _checked(task, fast) if fast is not None and shorter else None
        if motion is not None and price(motion) < last:
            best, last, failures = fast, price(motion), 0
            yield motion
        else:
            failures += best is not None
        if failures == SHORT.max_slower_phases or few.cancelled():
            break
    fast = None if best is None else _faster(few, best, TIGHT)
    motion = None if fast is None else _checked(task, fast)
    if motion is not None and price(motion) < last:
        yield motion


def _over(spent: Callable[[], float], most: float) -> bool:
    return spent() >= most


def _ever_fewer(task: TrajectoryProblem, phases: Sequence[Phase]) -> list[Knots]:
    """Return knots of a motion, of one with a cycle of modes less, with two cycles less, …"""
    problem, made = task.problem, [knots_of(task.problem, phases)]
    fewer: Sequence[Phase] | None = phases
    while fewer and not task.cancelled():
        guesses, fewer = islice(_without_a_cycle(problem, fewer), SHORT.max_failed_phases), None
        for guess in guesses:
            knots = _feasible(
                task, knots_of(problem, guess), SHORT.coarse_phase_violation, SHORT.phase_pace
            )
            if knots is not None:
                made.append(knots)
                fewer = guess
                break
    return made


def _feasible(
    task: TrajectoryProblem, guess: Knots, enough: float, pace: float = SQP.min_decrease
) -> Knots | None:
    """Return knots near a guess that violate nothing by more than ``enough`` in all; or None."""
    return restore_feasibility(
        task, guess, iterations=SHORT.far_iterations, lengths=_lengths(task, guess),
        enough=enough, pace=pace, penalty=SQP.bold_penalty,
    )  # fmt: skip


def _lengths(task: TrajectoryProblem, guess: Knots) -> tuple[Array, Array]:
    """Return bounds of the step lengths near a guess: a transition takes place within a step."""
    shorter, longer = SHORT.stretch
    longer = min(longer, max(1.0, most_time(task.problem) / guess.duration))
    return np.maximum(shorter * guess.lengths, _least(task.problem)), longer * guess.lengths


def _least(problem: PlanningTask) -> float:
    return 2 * NLP.transition_lag * problem.step


def _faster(task: TrajectoryProblem, guess: Knots, tolerances: StoppingTolerances) -> Knots | None:
    """Return knots of a short duration, or of little cost, near a guess; None if there are none."""
    knots = _feasible(task, guess, SQP.closure_tolerance)
    if knots is None:
        return None
    longest = knots.lengths
    if task.problem.cost_entry is not None:  # which may be less where it takes longer
        longest = _lengths(task, knots)[1]
    lengths = (_least(task.problem), longest)
    return minimize_cost(task, knots, lengths, tolerances=tolerances)


def _checked(task: TrajectoryProblem, knots: Knots) -> Trajectory | None:
    """Re-simulate knots in steps of the problem; None if that is infeasible.

    Violations between the samples of the coarse knots are repaired.
    """
    problem = task.problem
    times = [covering_steps(length, problem.step) for length in knots.lengths.tolist()]
    fine = refined(problem, knots, np.array(times))
    fine = fine.with_lengths(np.maximum(fine.lengths, _least(problem)))
    for _ in range(SHORT.max_tightenings):
        shortest, longest = _lengths(task, fine)
        lengths = (shortest, np.minimum(longest, problem.step))
        mended = restore_feasibility(
            task, fine, iterations=SHORT.far_iterations, lengths=lengths, pace=SHORT.phase_pace
        )
        if mended is None:
            return None
        made = true_trajectory(problem, mended)
        if made is None or satisfies_all(task, made):
            return made
        task, fine = task.tightened(excess_between_knots(task, made)), mended
    return None


@dataclass(frozen=True, eq=False)
class Phase:
    """A smooth part of a motion.

    Attributes:
        t: Times of its knots in [s], shape (N+1,).
        x: States there, from after one transition to before the next, shape (N+1, nx).
        u: Inputs, shape (N, nu).
        number: Of the transition with which it begins, among those from the mode before; 0 for
            the first phase.
    """

    t: Array
    x: Array
    u: Array
    number: int

    @property
    def duration(self) -> float:
        """Duration in [s]."""
        return float(self.t[-1] - self.t[0])


def phases_of(problem: PlanningTask, motion: Trajectory) -> list[Phase]:
    """Divide a motion at its transitions, which are located within its steps."""
    u, spans = motion.inputs, np.diff(motion.t)
    step = step_map(problem, Knots(motion.x, u, float(spans.max(initial=0.0))))
    phases: list[Phase] = []
    x, number = motion.x[0], 0
    t, states = [0.0], [x]
    inputs: list[Array] = []
    for k, span in enumerate(spans.tolist()):
        now, rest = float(motion.t[k] - motion.t[0]), span
        while rest > 0.0:
            gone, after, leaving = _until_transition(problem, step, x, u[k], rest)
            now, rest = now + gone, rest - gone
            if gone > 0.0:
                t, states, inputs = [*t, now], [*states, after], [*inputs, u[k]]
            x = after
            if leaving:
                phases.append(_phase(t, states, inputs, number))
                x, number = problem.model.after_transition(after, u[k], leaving), leaving
                t, states, inputs = [now], [x], []
    return [*phases, _phase(t, states, inputs, number)]


def _phase(t: Sequence[float], x: Sequence[Array], u: Sequence[Array], number: int) -> Phase:
    return Phase(np.array(t), np.array(x), np.array(u).reshape(len(t) - 1, -1), number)


def _until_transition(
    problem: PlanningTask, step: StepSensitivities, x: Array, u: Array, span: float
) -> tuple[float, Array, int]:
    """Return how long a smooth motion lasts, where it ends, and which transition ends it.

    Args:
        step: The map of a smooth step.
        x: State from which it begins, shape (nx,).
        u: Inputs, shape (nu,).
        span: How long it lasts at most, in [s].

    Returns:
        The time in [s], at most the span; the state, shape (nx,); the transition's number, or 0.
    """

    def after(time: float) -> tuple[Array, int]:
        y = step.after(x[None], u[None], time)[0]
        guard, rate, condition = problem.model.guards(y, u).T
        taken = np.flatnonzero((guard <= 0) & (rate < 0) & (condition > 0))
        return y, int(taken[0]) + 1 if len(taken) else 0

    low, high, (y, number) = 0.0, span, after(span)
    if not number:
        return span, y, 0
    for _ in range(52):  # halvings of a step, to locate a transition: to rounding
        middle = (low + high) / 2
        found = after(middle)
        if found[1]:
            high, (y, number) = middle, found
        else:
            low = middle
    return high, y, number


def knots_of(problem: PlanningTask, phases: Sequence[Phase]) -> Knots:
    """Return knots of a motion in phases of equally many steps, each with a length of its own."""
    steps = max(SHORT.phase_steps, math.ceil(SHORT.coarse_knots / len(phases)))
    few = [resampled(p.t, p.x, p.u, steps, problem.space) for p in phases]
    lengths = np.maximum([part.h for part in few], _least(problem))
    x = np.vstack([few[0].x[:1], *(part.x[1:] for part in few)])
    x[1:, -1] = np.repeat([p.x[0, -1] for p in phases], steps)
    numbers = tuple(p.number for p in phases[1:])
    begins = steps * np.arange(1, len(phases))
    h = float(lengths.max())
    u = np.vstack([part.u for part in few])
    return Knots(x, u, h, Phases(begins, numbers, lengths / h))


def _without_a_cycle(problem: PlanningTask, phases: Sequence[Phase]) -> Iterator[list[Phase]]:
    """Yield guesses without a cycle of modes, or without the last phase, small gaps first."""
    begins, modes = [p.x[0] for p in phases], [p.x[0, -1] for p in phases]
    found = []
    for a, b in combinations(range(1, len(phases)), 2):
        if modes[a] == modes[b]:
            weights = np.where(cyclic_coordinates(problem), 0.0, problem.weights)
            gap = float(problem.space.distance(begins[a], begins[b], weights))
            found.append((gap, a, b))
    for _, a, b in sorted(found):
        yield _without(phases, a, b)


def _without(phases: Sequence[Phase], a: int, b: int) -> list[Phase]:
    """Return a guess without phases a to b - 1, the gap spread over the others by time."""
    kept = [*phases[:a], *phases[b:]]
    total, now = sum(p.duration for p in kept), 0.0
    gap, made = phases[b].x[0] - phases[a].x[0], []
    for k, phase in enumerate(kept):
        part = ((now + phase.t - phase.t[0]) / total)[:, None]
        now += phase.duration
        x = phase.x + (part * gap if k < a else (part - 1) * gap)
        made.append(replace(phase, x=x, number=phases[a].number if k == a else phase.number))
    return made
