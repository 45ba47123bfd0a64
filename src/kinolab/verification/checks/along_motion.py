"""Checks of requirements and limits along the re-simulated motion, also between knots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.intervals import IntervalArray
from kinolab.problem import PlanningTask
from kinolab.verification.boxes import MostExcess, hidden_excess
from kinolab.verification.check import LIMIT_TOLERANCE, Check, CheckContext, worst_along
from kinolab.verification.peaks import Excess, peaks

# Of the largest magnitude of a requirement along the motion, or of a limit: what interval
# arithmetic leaves to samples, which are exact where nothing changes faster than the machine moves.
LEFT_TO_SAMPLES = 1e-2

Violations = Iterator[tuple[float, str]]


def requirements(context: CheckContext) -> Check | None:
    """Check the machine's requirements along the motion, under zero-order-hold inputs."""
    if not context.problem.machine.requirements or not len(context.stored.u):
        return None
    found = worst_along("requirements", _unmet(context))
    return worst_along("requirements", _unmet_in_an_instant(context)) if found.passed else found


def limits(context: CheckContext) -> Check:
    """Check state and rate limits, the workspace and keep-out cones."""
    found = worst_along("limits", _passed(context))
    return worst_along("limits", _passed_in_an_instant(context)) if found.passed else found


def _unmet(context: CheckContext) -> Violations:
    """Yield the largest requirement violation of each batch of samples, and of peaks between."""
    named, excess = context.problem.machine.requirements, _shortage(context)
    for times, states, held in context.dense_motion.samples():
        short = excess(states, held)
        between = peaks(context.dense_motion, times, short, excess, LIMIT_TOLERANCE)
        for at, lack in ((times, short), (between[0], excess(*between[1:]))):
            if lack.size:
                k, i = np.unravel_index(int(lack.argmax()), lack.shape)
                words = f"at t = {at[k]:.6g} s {named[int(i)].name}: short by {lack[k, i]:.4g}"
                yield float(lack[k, i]), words


def _unmet_in_an_instant(context: CheckContext) -> Violations:
    """Yield a requirement that may be violated between samples."""
    dense, excess = context.dense_motion, _shortage(context)
    names = [requirement.name for requirement in context.problem.machine.requirements]
    ends = excess(dense.motion.x[:-1], dense.trajectory.u)
    slack = LIMIT_TOLERANCE + LEFT_TO_SAMPLES * np.abs(ends).max(axis=0)
    yield from _hidden(context, names, slack, lambda x, u: -dense.enclosures.requirements(x, u).low)


def _shortage(context: CheckContext) -> Excess:
    plant = context.problem.model.plant

    def excess(states: Array, held: Array) -> Array:
        margins = plant.requirements(states, held)
        return np.where(np.isfinite(margins), -margins, np.inf)

    return excess


def _passed(context: CheckContext) -> Violations:
    """Yield the limit violations at every sample, and at peaks between samples."""
    problem = context.problem

    def excess(states: Array, _: Array) -> Array:
        return problem.limit_excess(states)

    for times, states, held in context.dense_motion.samples():
        yield from _passed_at(problem, times, states)
        found = excess(states, held)
        at, beside, _ = peaks(context.dense_motion, times, found, excess, LIMIT_TOLERANCE)
        yield from _passed_at(problem, at, beside)


def _passed_at(problem: PlanningTask, times: Array, states: Array) -> Violations:
    """Yield the limit violations at some times."""
    for j in np.flatnonzero(problem.outside_limits(states)):
        for name, value, lower, upper in problem.limit_violations(states[j]):
            found = f"at t = {times[j]:.6g} s {name} is {value:.9g}"
            words = f"{found}, outside {lower:g} to {upper:g}"
            yield max(value - upper, lower - value), words


def _passed_in_an_instant(context: CheckContext) -> Violations:
    """Yield a limit of a state entry or of a rate that may be passed between samples."""
    problem, enclosures = context.problem, context.dense_motion.enclosures
    names, bounds = problem.model.state_names, problem.bounds
    rates = bool(np.isfinite(problem.rate_bounds).any())
    if rates:
        names, bounds = names + problem.model.rate_names, np.vstack([bounds, problem.rate_bounds])

    def most(x: IntervalArray, u: Array) -> Array:
        low, high = x.low, x.high
        if rates:
            v = enclosures.velocities(x, u)
            low, high = np.hstack([low, v.low]), np.hstack([high, v.high])
        return np.maximum(high - bounds[:, 1], bounds[:, 0] - low)

    sizes = np.where(np.isfinite(bounds), np.abs(bounds), 0.0).max(axis=1)
    yield from _hidden(context, names, LIMIT_TOLERANCE + LEFT_TO_SAMPLES * sizes, most)


def _hidden(
    context: CheckContext, names: Sequence[str], slack: Array, most: MostExcess
) -> Violations:
    """Yield a violation that no sample has and interval arithmetic cannot rule out."""
    pieces = context.dense_motion.pieces
    found = pieces and hidden_excess(pieces, context.trajectory.u, most, slack)
    if found:
        time, excess, i = found
        words = f"between two samples {names[i]} may be off by up to {excess:.4g}"
        yield excess, f"at t = {time:.6g} s {words}"
