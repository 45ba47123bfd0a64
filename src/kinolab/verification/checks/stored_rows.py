"""Checks of the stored rows alone: numbers, times, constraints and inputs."""

from __future__ import annotations

import numpy as np

from kinolab.dynamics.analysis.consistent_states import CONSTRAINT_TOLERANCE
from kinolab.verification.checks.check import (
    LIMIT_TOLERANCE,
    Check,
    CheckContext,
    judged,
    worst_entry,
)


def numbers(context: CheckContext) -> Check:
    """Check that all numbers are finite and all modes exist; the value counts those that do not."""
    tables = {name: getattr(context.stored, name) for name in ("t", "x", "u", "references")}
    broken = [name for name, table in tables.items() if not np.isfinite(table).all()]
    count = sum(int((~np.isfinite(table)).sum()) for table in tables.values())
    detail = f"not finite: {', '.join(broken)}"
    modes, lost = context.problem.machine.modes, np.zeros(0, np.intp)
    if modes:
        lost = np.flatnonzero(~np.isin(context.stored.x[:, -1], range(len(modes))))
    if not broken and lost.size:
        most = len(modes) - 1
        detail = f"row {lost[0]} is in mode {context.stored.x[lost[0], -1]:g}; they are 0 to {most}"
    return judged("numbers", float(count + lost.size), 0.0, detail)


def times(context: CheckContext) -> Check:
    """Check that times start at 0 and increase, by exactly one step in a discrete problem.

    The value counts the violations.
    """
    t, problem = context.stored.t, context.problem
    steps = np.diff(t)
    bad, detail = np.flatnonzero(~(steps > 0)), "row {} does not come after the row before"
    if not bad.size and problem.scenario.integration.truth == "discrete":
        # relative deviation from a discrete problem's step: times accumulate rounding
        whole = np.isclose(steps, problem.step, rtol=1e-6, atol=0.0)
        bad, detail = np.flatnonzero(~whole), "row {} does not come one step after the row before"
    late = abs(float(t[0])) > 0
    text = detail.format(bad[0] + 1) if bad.size else "t starts late"
    return judged("time", float(bad.size + late), 0.0, text)


def duration(context: CheckContext) -> Check | None:
    """Check that the motion takes no longer than [objective] max_time; the value is in [s]."""
    section = context.problem.scenario.objective
    if section is None or section.max_time is None:
        return None
    taken = float(np.ptp(context.stored.t[[0, -1]]))
    return judged("duration", taken, section.max_time + LIMIT_TOLERANCE, "it takes longer")


def constraints(context: CheckContext) -> Check:
    """Check w(q) q_dot and h(q) at every knot, under the input held from it on."""
    problem, trajectory = context.problem, context.trajectory
    plant, u, residual = problem.model.plant, trajectory.u, np.zeros((0, 0))
    if problem.machine.constraints and len(u):
        held = np.vstack([u, u[-1:]])
        residual = np.abs(plant.constraint_residual(trajectory.x, held))

    def words(k: int, i: int) -> str:
        return f"at t = {trajectory.t[k]:.6g} s {plant.residual_names[i]} is broken"

    return worst_entry("constraints", residual, CONSTRAINT_TOLERANCE, words)


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
    """Check that the stored inputs follow the feedback law at the stored states."""
    trajectory, model = context.trajectory, context.problem.model
    plant, u = model.plant, trajectory.u
    if plant is model or not len(u):
        return None
    given = model.plant_inputs(trajectory.x[:-1], trajectory.references)
    errors = np.abs(u - given) / np.ptp(plant.control_bounds, axis=1)

    def words(k: int, i: int) -> str:
        wrong = f"{u[k, i]:.9g} where the law gives {given[k, i]:.9g}"
        return f"at t = {trajectory.t[k]:.6g} s {plant.control_names[i]} is {wrong}"

    # of an input's range: allowed deviation from the feedback law
    return worst_entry("feedback", errors, 1e-9, words)
