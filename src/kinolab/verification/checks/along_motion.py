"""Checks of requirements and limits along the re-simulated motion, also between knots."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.verification.check import LIMIT_TOLERANCE, Check, CheckContext, worst_along
from kinolab.verification.peaks import peaks

Violations = Iterator[tuple[float, str]]


def requirements(context: CheckContext) -> Check | None:
    """Check the machine's requirements along the motion, under zero-order-hold inputs."""
    if not context.problem.machine.requirements or not len(context.stored.u):
        return None
    return worst_along("requirements", _unmet(context))


def limits(context: CheckContext) -> Check:
    """Check state and rate limits, the workspace and keep-out cones."""
    return worst_along("limits", _passed(context))


def _unmet(context: CheckContext) -> Violations:
    """Yield the largest requirement violation of each batch of samples, and of peaks between."""
    named, plant = context.problem.machine.requirements, context.problem.model.plant

    def excess(states: Array, held: Array) -> Array:
        margins = plant.requirements(states, held)
        return np.where(np.isfinite(margins), -margins, np.inf)

    for times, states, held in context.dense_motion.samples():
        short = excess(states, held)
        between = peaks(context.dense_motion, times, short, excess, LIMIT_TOLERANCE)
        for at, lack in ((times, short), (between[0], excess(*between[1:]))):
            if lack.size:
                k, i = np.unravel_index(int(lack.argmax()), lack.shape)
                words = f"at t = {at[k]:.6g} s {named[int(i)].name}: short by {lack[k, i]:.4g}"
                yield float(lack[k, i]), words


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
