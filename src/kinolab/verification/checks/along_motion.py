"""Checks of requirements and limits along the re-simulated motion, also between knots."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinolab.verification.check import Check, CheckContext, worst_along

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
    """Yield the largest requirement violation of each batch of samples."""
    named, plant = context.problem.machine.requirements, context.problem.model.plant
    for times, states, held in context.dense_motion.samples():
        margins = plant.requirements(states, held)
        short = np.where(np.isfinite(margins), -margins, np.inf)
        k, i = np.unravel_index(int(short.argmax()), short.shape)
        words = f"at t = {times[k]:.6g} s {named[int(i)].name}: short by {short[k, i]:.4g}"
        yield float(short[k, i]), words


def _passed(context: CheckContext) -> Violations:
    """Yield the limit violations at every sample."""
    problem = context.problem
    for times, states, _ in context.dense_motion.samples():
        for j in np.flatnonzero(problem.outside_limits(states)):
            for name, value, lower, upper in problem.limit_violations(states[j]):
                found = f"at t = {times[j]:.6g} s {name} is {value:.9g}"
                words = f"{found}, outside {lower:g} to {upper:g}"
                yield max(value - upper, lower - value), words
