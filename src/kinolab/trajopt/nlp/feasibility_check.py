"""Feasibility check of a re-simulated trajectory, by samples and the planners' collision check."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinolab.numerics.work import charge
from kinolab.problem.task import LIMIT_TOLERANCE
from kinolab.trajectory import Trajectory
from kinolab.trajopt.nlp.decision import Knots
from kinolab.trajopt.nlp.dynamics_constraint import repeatable, true_steps
from kinolab.trajopt.nlp.options import NLP
from kinolab.trajopt.nlp.path_constraints import PathConstraints, Samples, beginnings, samples
from kinolab.trajopt.nlp.problem import Excess, TrajectoryProblem


def satisfies_all(task: TrajectoryProblem, trajectory: Trajectory) -> bool:
    """Say whether a simulated motion ends in the goal and violates no constraint at samples."""
    charge(5e-3 + (3e-5 if task.discrete else 2.5e-4) * len(trajectory.inputs))
    return (
        task.problem.goal_excess(trajectory.x[-1]) <= 1.0
        and _breaks_nothing(task, _on_the_way(task, trajectory))
        and _begins_well(task, trajectory)
        and _stays_free(task, trajectory)
        and repeatable(task.problem, trajectory)
    )


def satisfies_all_at_knots(task: TrajectoryProblem, trajectory: Trajectory) -> bool:
    """Say the same of a motion whose steps have already been checked, from its knots alone."""
    return (
        task.problem.goal_excess(trajectory.x[-1]) <= 1.0
        and _breaks_nothing(task, samples(Knots(trajectory.x, trajectory.inputs, 1.0), 1))
        and _begins_well(task, trajectory)
        and repeatable(task.problem, trajectory)
    )


def excess_between_knots(task: TrajectoryProblem, trajectory: Trajectory) -> Excess:
    """Return how far a simulated motion passes limits at samples, nothing for what is rounding."""
    return _excess(task, _on_the_way(task, trajectory))


def _breaks_nothing(task: TrajectoryProblem, at: Samples) -> bool:
    return not _excess(task, at) and task.bare.free(at.x)


def _excess(task: TrajectoryProblem, at: Samples) -> Excess:
    lower, upper = task.problem.bounds.T
    passed = np.maximum(lower - at.x, at.x - upper).max(axis=0, initial=0.0)
    margins = PathConstraints(task.problem, 0.0).margins(at.x, at.u)
    missing = (-margins).max(axis=0, initial=0.0)
    parts = (np.where(part <= LIMIT_TOLERANCE, 0.0, part) for part in (passed, missing))
    return Excess(*parts)


def _begins_well(task: TrajectoryProblem, trajectory: Trajectory) -> bool:
    """Say whether input-dependent constraints are satisfied where each step begins."""
    at = beginnings(Knots(trajectory.x, trajectory.inputs, 1.0))
    margins = PathConstraints(task.problem, 0.0, begins=True).margins(at.x, at.u)
    return bool(margins.min(initial=0.0) >= -LIMIT_TOLERANCE)


def _stays_free(task: TrajectoryProblem, trajectory: Trajectory) -> bool:
    """Say whether every step passes the planners' continuous collision check."""
    judge, spans = task.judge, np.diff(trajectory.t).tolist()
    steps = zip(trajectory.x.tolist(), trajectory.inputs.tolist(), spans, strict=False)
    return all(judge.touches_nothing(x, u, span) for x, u, span in steps)


def _on_the_way(task: TrajectoryProblem, trajectory: Trajectory) -> Samples:
    """Sample the integrated motion between knots, or straight lines if it is discrete."""
    spans = np.round(np.diff(trajectory.t), NLP.duration_digits)
    knots = Knots(trajectory.x, trajectory.inputs, float(spans.max(initial=0.0)))
    at = samples(knots, NLP.check_factor * task.samples_per_step(knots))
    if task.discrete:
        return at
    after, count = true_steps(task.problem, knots), len(at.x) // max(len(knots.u), 1)
    x = at.x.copy().reshape(-1, count, at.x.shape[1])
    for span in np.unique(spans):
        own = np.flatnonzero(spans == span)
        before, held = knots.x[own], knots.u[own]
        for k, fraction in enumerate(at.share[:count].tolist()):
            x[own, k] = after(before, held, fraction * float(span))
    return replace(at, x=x.reshape(at.x.shape))
