"""Checks of requirements and limits along the re-simulated motion, also between knots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.intervals import IntervalArray
from kinolab.problem import PlanningTask
from kinolab.problem.goal import KeepOutCone
from kinolab.simulation.motion_pieces import MotionPieces
from kinolab.verification.between_samples.boxes import MostExcess, hidden_excess
from kinolab.verification.between_samples.peaks import Excess, peaks
from kinolab.verification.checks.check import (
    LIMIT_TOLERANCE,
    Check,
    CheckContext,
    worst_along,
    worst_entry,
)

# Of the size of its terms, or of a limit: what interval arithmetic leaves to samples, which see all
# that changes no faster than the machine moves. Of the states themselves, which are polynomials:
LEFT_TO_SAMPLES, LEFT_OF_STATES = 1e-2, 1e-6

Violations = Iterator[tuple[float, str]]


def requirements(context: CheckContext) -> Check | None:
    """Check the machine's requirements along the motion, under zero-order-hold inputs."""
    if not context.problem.machine.requirements:
        return None
    if not len(context.stored.u):  # without a step there are no inputs
        named, start = context.problem.machine.requirements, context.motion.x[:1]
        short = _shortage(context)(start, np.zeros((1, context.problem.model.plant.nu)))
        return worst_entry(
            "requirements", short, LIMIT_TOLERANCE, lambda _, i: f"{named[i].name} at the start"
        )
    found = worst_along("requirements", _unmet(context))
    if not found.passed or context.dense_motion.pieces is None:
        return found
    return worst_along("requirements", _unmet_in_an_instant(context, context.dense_motion.pieces))


def limits(context: CheckContext) -> Check:
    """Check state and rate limits, the workspace and keep-out cones."""
    found = worst_along("limits", _passed(context))
    if not found.passed or context.dense_motion.pieces is None:
        return found
    return worst_along("limits", _passed_in_an_instant(context, context.dense_motion.pieces))


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


def _unmet_in_an_instant(context: CheckContext, pieces: MotionPieces) -> Violations:
    """Yield a requirement that may be violated between samples."""
    dense, excess = context.dense_motion, _shortage(context)
    if not dense.enclosures.encloses_requirements:
        return
    names = [requirement.name for requirement in context.problem.machine.requirements]

    def most(x: IntervalArray, u: Array) -> Array:
        margins, sizes = dense.enclosures.requirements(x, u)
        slack = LIMIT_TOLERANCE + LEFT_TO_SAMPLES * np.where(np.isfinite(sizes), sizes, 0.0)
        return np.asarray(-margins.low - slack)

    yield from _hidden(context, pieces, names, most, excess)


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
    """Yield the limit violations at the worst of some times."""
    outside = np.flatnonzero(problem.outside_limits(states))
    if len(outside) > 100:  # violations in a batch of samples, of which only the worst are told
        worst = problem.limit_excess(states[outside]).argmax(axis=0)
        outside = outside[np.unique(worst)]
    for j in outside:
        for name, value, lower, upper in problem.limit_violations(states[j]):
            found = f"at t = {times[j]:.6g} s {name} is {value:.9g}"
            words = f"{found}, outside {lower:g} to {upper:g}"
            yield max(value - upper, lower - value), words


def _passed_in_an_instant(context: CheckContext, pieces: MotionPieces) -> Violations:
    """Yield a limit of a state entry, of a rate or of a cone that may be passed between samples."""
    problem, enclosures = context.problem, context.dense_motion.enclosures
    rates, cones = bool(np.isfinite(problem.rate_bounds).any()), problem.keep_outs
    bounds, left = problem.bounds, [LEFT_OF_STATES] * len(problem.bounds)
    names = [*problem.model.state_names]
    if rates:
        names += problem.model.rate_names
        bounds = np.vstack([bounds, problem.rate_bounds])
        left += [LEFT_TO_SAMPLES] * len(problem.rate_bounds)
    names += [f"the axis of {problem.bodies[cone.body].name}" for cone in cones]
    sizes = np.where(np.isfinite(bounds), np.abs(bounds), 0.0).max(axis=1)
    slack = LIMIT_TOLERANCE + np.array(left) * sizes

    def most(x: IntervalArray, u: Array) -> Array:
        low, high = x.low, x.high
        if rates:
            v = enclosures.velocities(x, u)
            low, high = np.hstack([low, v.low]), np.hstack([high, v.high])
        passed = [np.maximum(high - bounds[:, 1], bounds[:, 0] - low) - slack]
        if cones:
            frames = enclosures.frames(x, u)
            angles = [_least_angle(cone, frames) for cone in cones]
            passed += [
                ((1 - LEFT_TO_SAMPLES) * cone.half_angle - angle)[:, None]
                for cone, angle in zip(cones, angles, strict=True)
            ]
        return np.hstack(passed)

    def excess(states: Array, _: Array) -> Array:
        passed = problem.limit_excess(states)  # the workspace lies between these and the cones
        return np.hstack([passed[:, : len(bounds)], passed[:, passed.shape[1] - len(cones) :]])

    yield from _hidden(context, pieces, names, most, excess)


def _least_angle(cone: KeepOutCone, frames: IntervalArray) -> Array:
    """Return the least angle in [rad] between a cone's direction and its axis, shape (m,).

    Args:
        cone: Its body, axis and direction.
        frames: Boxes of poses, shape (m, bodies, 12).
    """
    weights = np.zeros((3, 4))
    weights[:, :3] = np.outer(cone.direction, cone.axis)
    up, down = np.maximum(weights, 0.0).ravel(), np.minimum(weights, 0.0).ravel()
    cosine = frames.high[:, cone.body] @ up + frames.low[:, cone.body] @ down
    return np.arccos(np.clip(np.nan_to_num(cosine, nan=1.0), -1.0, 1.0))


def _hidden(
    context: CheckContext,
    pieces: MotionPieces,
    names: Sequence[str],
    most: MostExcess,
    excess: Excess,
) -> Violations:
    """Yield a violation that no sample has and interval arithmetic cannot rule out."""
    u = context.trajectory.u

    def at_ends(some: MotionPieces) -> Array:
        first, last = (excess(x, u[some.knots]) for x in some.ends)
        return np.maximum(first, last) - LIMIT_TOLERANCE

    found = hidden_excess(pieces, u, most, at_ends)
    if found:
        time, passed, i = found
        words = f"between two samples {names[i]} may be off by up to {passed:.4g}"
        yield passed, f"at t = {time:.6g} s {words}"
