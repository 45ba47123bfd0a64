"""Dynamics constraints between knots: step maps with adaptive substeps, and their derivatives."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.methods import METHODS, RK4, Method
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.dop853_coefficients import DOP853
from kinolab.simulation.machine import states_under
from kinolab.simulation.reference import (
    MAX_ERROR_AMPLIFICATION,
    DivergedError,
    error_amplification,
    perturbed_start,
    reference_motion,
    resimulate,
    trajectory_under,
)
from kinolab.simulation.sensitivities import StepSensitivities
from kinolab.trajectory import Trajectory
from kinolab.trajopt.nlp.decision import ONE_PHASE, Knots
from kinolab.trajopt.nlp.options import NLP, SHORT
from kinolab.trajopt.nlp.transitions import Transitions

# Methods that are tried in turn, with the fewest and the most substeps of each: order 8 pays where
# steps are long, and where a machine is stiff it does not.
TRIED = ((RK4, 1, 4), (DOP853, 1, 16), (RK4, 4, NLP.max_substeps))


def is_discrete(problem: PlanningTask) -> bool:
    """Say whether the problem's dynamics are discrete: one map with a fixed step length."""
    return problem.scenario.integration.truth == "discrete"


def step_map(problem: PlanningTask, knots: Knots) -> StepSensitivities:
    """Return the discrete-time map from knot to knot."""
    return StepSensitivities(problem.model, *_steps_of(problem, knots))


def true_steps(problem: PlanningTask, knots: Knots) -> Callable[[Array, Array, float], Array]:
    """Return what makes steps, through transitions between modes as well.

    Args:
        knots: Near which the steps are accurate.

    Returns:
        From states (N, nx), inputs (N, nu) and one length in [s] to the states after, (N, nx).
    """
    method, substeps = _steps_of(problem, knots)
    if not problem.machine.modes:
        return StepSensitivities(problem.model, method, substeps).after
    known = method.name in problem.model.methods
    name, substeps = (method.name, substeps) if known else (RK4.name, NLP.max_substeps)
    return partial(problem.model.step, method=name, substeps=substeps)


def derived_map(problem: PlanningTask, knots: Knots, times: int) -> StepSensitivities:
    """Return the step map with derivatives accurate enough for a search direction."""
    model = problem.model
    acts = 1 if model.plant is model else times
    method, substeps = _steps_of(problem, knots, acts)
    if is_discrete(problem):
        return StepSensitivities(model, method, times * substeps // acts, acts=acts)
    step = partial(StepSensitivities, model, method, acts=acts)
    some = slice(None, None, NLP.sampled_step_stride)
    x, u, spans = knots.x[:-1][some], knots.u[some], knots.lengths[knots.phase][some]
    few, coarse = 1, step(1).linearized(x, u, spans)[1]
    large = np.repeat(problem.scales[:, None], coarse.shape[2], axis=1)
    large[:, : model.nx] /= problem.scales
    while few < substeps:
        fine = step(2 * few).linearized(x, u, spans)[1]
        if _apart(coarse, fine, large) <= NLP.derivative_tolerance:
            break
        few, coarse = 2 * few, fine
    return step(substeps, few)


def refined(problem: PlanningTask, knots: Knots, times: int | NDArray[np.int64]) -> Knots:
    """Return the motion under the same inputs with every step split.

    Args:
        knots: Of the motion.
        times: Into how many steps, all or those of each phase, shape (P,).
    """
    parts_of = np.broadcast_to(times, len(knots.lengths))
    short, count = knots.with_lengths(knots.lengths / parts_of), parts_of[knots.phase]
    step, parts = step_map(problem, short), [knots.x[:-1]]
    begin, spans = Transitions(problem, step, 0.0).entered(short)
    for _ in range(int(count.max(initial=1)) - 1):
        begin, spans = step.after(begin, knots.u, spans), short.lengths[short.phase]
        parts.append(begin)
    x = np.stack(parts, axis=1)[np.arange(len(parts)) < count[:, None]]
    phases = short.phases
    if phases is not ONE_PHASE:
        firsts = np.cumsum(count) - count
        phases = replace(phases, begins=firsts[phases.begins])
    u = np.repeat(knots.u, count, axis=0)
    return replace(short, x=np.vstack([x, knots.x[-1:]]), u=u, phases=phases)


def true_trajectory(problem: PlanningTask, knots: Knots) -> Trajectory | None:
    """Re-simulate the inputs of knots; None if the simulation diverges."""
    model = problem.model
    u = np.clip(knots.u, *model.control_bounds.T)
    t = knots.times
    if is_discrete(problem):
        x = states_under(problem, u)
        if not np.isfinite(x).all():
            return None
        return trajectory_under(model, t, x, u)
    try:
        return resimulate(problem, t, u)
    except DivergedError:
        return None


def is_motion(problem: PlanningTask, trajectory: Trajectory) -> bool:
    """Say whether a trajectory begins at the start and has no defects."""
    begin = np.abs((trajectory.x[0] - problem.start) / problem.scales)
    largest = np.append(begin, _defects(problem, trajectory))
    return bool((largest <= SHORT.defect_tolerance).all())  # a step that diverges has a defect


def smooth_pieces(problem: PlanningTask, trajectory: Trajectory) -> list[tuple[int, int]]:
    """Return first and last knot of the pieces of a motion between transitions of the machine.

    A step in which a transition takes place belongs to no piece.
    """
    if not problem.machine.modes:
        return [(0, len(trajectory.u))]
    switching = ~(_defects(problem, trajectory) <= SHORT.defect_tolerance)
    ends = [-1, *np.flatnonzero(switching).tolist(), len(switching)]
    return [(before + 1, last) for before, last in itertools.pairwise(ends) if last > before + 1]


def _defects(problem: PlanningTask, trajectory: Trajectory) -> Array:
    """Return how far each smooth step ends from the next knot, scaled, shape (N,)."""
    spans = np.round(np.diff(trajectory.t), NLP.duration_digits)
    step = step_map(problem, Knots(trajectory.x, trajectory.inputs, float(spans.max(initial=0.0))))
    defects = np.zeros(len(spans))
    for span in np.unique(spans):
        own = np.flatnonzero(spans == span)
        after = step.after(trajectory.x[own], trajectory.inputs[own], float(span))
        with np.errstate(over="ignore", invalid="ignore"):
            apart = np.abs((after - trajectory.x[own + 1]) / problem.scales)
        defects[own] = apart.max(axis=1, initial=0.0)
    return defects


def repeatable(problem: PlanningTask, trajectory: Trajectory) -> bool:
    """Say whether the error amplification is small enough to execute the motion open-loop."""
    start = perturbed_start(problem, problem.start)
    if problem.machine.modes:  # which may take place later, or never
        try:
            far = reference_motion(problem, start, trajectory.t, trajectory.inputs, between=False)
        except DivergedError:
            return False
        return error_amplification(problem, trajectory.x, far.x) <= MAX_ERROR_AMPLIFICATION
    h = float(np.diff(trajectory.t).max(initial=0.0)) or 1.0
    x = np.vstack([start, np.empty((len(trajectory.inputs), len(start)))])
    step = step_map(problem, Knots(trajectory.x, trajectory.inputs, h))
    for k in range(len(trajectory.inputs)):
        span = float(trajectory.t[k + 1] - trajectory.t[k])
        x[k + 1] = step.after(x[k : k + 1], trajectory.inputs[k : k + 1], span)[0]
    return error_amplification(problem, trajectory.x, x) <= MAX_ERROR_AMPLIFICATION


def _steps_of(problem: PlanningTask, knots: Knots, acts: int = 1) -> tuple[Method, int]:
    """Return an integration method and the number of substeps that is accurate enough."""
    settings, model = problem.scenario.integration, problem.model
    if is_discrete(problem):
        return METHODS[settings.method], settings.substeps
    spans = knots.lengths[knots.phase]
    for method, fewest, most in TRIED:
        substeps, step = fewest, partial(StepSensitivities, model, method, acts=acts)
        coarse = step(substeps).after(knots.x, knots.u, spans)
        while substeps < most:
            fine = step(2 * substeps).after(knots.x, knots.u, spans)
            if _apart(coarse, fine, problem.scales) <= NLP.step_tolerance:
                return method, substeps
            substeps, coarse = 2 * substeps, fine
    if np.isfinite(coarse).all():
        return RK4, substeps
    # so stiff that only implicit steps stay bounded
    return METHODS[settings.accurate_method], substeps


def _apart(coarse: Array, fine: Array, scales: Array) -> float:
    """Return the largest scaled difference; NaN or infinite where a long step diverges."""
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.abs((coarse - fine) / scales).max(initial=0.0))
