"""Are the stored inputs within their limits, and what the feedback law gives?"""

from __future__ import annotations

import numpy as np

from kinolab.verification.check import LIMIT_TOLERANCE, Check, CheckContext, worst_entry

FEEDBACK_TOLERANCE = 1e-9  # of an input's range: how far it may be from what the law gives


def inputs(context: CheckContext) -> Check:
    """Check that inputs, and the references of feedback, are within their limits."""
    trajectory, model = context.trajectory, context.problem.model
    plant = model.plant
    names, held, limits = plant.control_names, trajectory.u, plant.control_bounds
    if plant is not model:
        names, held = (*names, *model.control_names), np.hstack([held, trajectory.references])
        limits = np.vstack([limits, model.control_bounds])
    lower, upper = limits.T
    beyond = np.maximum(np.maximum(held - upper, lower - held), 0.0)

    def words(k: int, i: int) -> str:
        outside = f"{held[k, i]:.9g}, outside {lower[i]:g} to {upper[i]:g}"
        return f"at t = {trajectory.t[k]:.6g} s {names[i]} is {outside}"

    finite = np.where(np.isfinite(beyond), beyond, np.inf)
    return worst_entry("inputs", finite, LIMIT_TOLERANCE, words)


def feedback(context: CheckContext) -> Check | None:
    """Check that the stored inputs are what the law gives at the stored states."""
    trajectory, model = context.trajectory, context.problem.model
    plant, u = model.plant, trajectory.u
    if plant is model or not len(u):
        return None
    given = model.plant_inputs(trajectory.x[:-1], trajectory.references)
    errors = np.abs(u - given) / np.ptp(plant.control_bounds, axis=1)

    def words(k: int, i: int) -> str:
        wrong = f"{u[k, i]:.9g} where the law gives {given[k, i]:.9g}"
        return f"at t = {trajectory.t[k]:.6g} s {plant.control_names[i]} is {wrong}"

    return worst_entry("feedback", errors, FEEDBACK_TOLERANCE, words)
