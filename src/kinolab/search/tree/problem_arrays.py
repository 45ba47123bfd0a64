"""A problem as arrays for compiled kernels: limits, metric, goal and sampling."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel
from kinolab.numerics.manifolds.state_parts import sphere_table
from kinolab.numerics.rng import below, uniform, unit_vector
from kinolab.problem import PlanningTask
from kinolab.problem.goal import SEARCHED_FRACTION
from kinolab.problem.goal_kernel import (
    GoalArrays,
    body_violation,
    goal_arrays,
    state_violation,
    wrapped_angle,
)
from kinolab.search.tree.flat_arrays import copy
from kinolab.simulation.collision_context import place_machine
from kinolab.simulation.limits import LimitArrays, limit_arrays


class ProblemArrays(NamedTuple):
    """A problem as plain arrays."""

    start: Array  # (nx,)
    limits: LimitArrays
    lower: Array  # (nx,) finite sampling bounds
    upper: Array  # (nx,)
    spheres: Integers  # (spheres, 3), as ``sphere_table``
    input_lower: Array  # (nu,)
    input_upper: Array  # (nu,)
    entry: Integers  # (d,) entries of the state in the metric
    weight: Array  # (d,)
    circular: NDArray[np.bool_]  # (d,)
    goal: GoalArrays
    goal_samples: Array  # (states, nx) around the goal
    goal_states: Array  # (states, nx) in the goal
    step: float  # of propagation, in [s]
    cost_entry: int  # the entry of the state that is the cost so far; -1 where steps are counted


def gather_problem(problem: PlanningTask, goal_region_scale: float, seed: int) -> ProblemArrays:
    """Collect the arrays; goal samples reach out to ``goal_region_scale`` tolerances."""
    model, random = problem.model, np.random.default_rng(seed)
    entry = np.flatnonzero(problem.weights > 0)
    spreads = goal_region_scale ** random.uniform(size=4096)  # precomputed samples around the goal
    return ProblemArrays(
        start=np.clip(problem.start, *problem.bounds.T),
        limits=limit_arrays(problem),
        lower=_row(problem.sampling_bounds[:, 0]),
        upper=_row(problem.sampling_bounds[:, 1]),
        spheres=sphere_table(model.space.spheres),
        input_lower=_row(model.control_bounds[:, 0]),
        input_upper=_row(model.control_bounds[:, 1]),
        entry=entry.astype(np.int64),
        weight=_row(problem.weights[entry]),
        circular=np.ascontiguousarray(problem.circular[entry]),
        goal=goal_arrays(problem.goal),
        goal_samples=problem.sample_goals(random, spreads),
        goal_states=problem.sample_goals(random, np.ones(256)),  # precomputed samples in the goal
        step=problem.step,
        cost_entry=-1 if problem.cost_entry is None else problem.cost_entry,
    )


def metric_periods(arrays: ProblemArrays) -> Array:
    """Return the period of each scaled coordinate, infinite if it has none, shape (d,)."""
    return np.where(arrays.circular, 2 * np.pi * arrays.weight, np.inf)


def _row(values: Array) -> Array:
    return np.ascontiguousarray(values, dtype=float)


@kernel
def metric_coordinates(arrays, x, out):  # type: ignore[no-untyped-def]
    """Write the scaled coordinates (d,) of a state (nx,) in the metric, angles wrapped."""
    for i in range(arrays.entry.shape[0]):
        value = x[arrays.entry[i]]
        if arrays.circular[i]:
            value = wrapped_angle(value)
        out[i] = arrays.weight[i] * value


@kernel
def sample_state(arrays, random, bias, x):  # type: ignore[no-untyped-def]
    """Sample a state (nx,): around the goal with probability ``bias``, else uniformly."""
    if uniform(random) < bias:
        row = arrays.goal_samples[below(random, arrays.goal_samples.shape[0])]
        copy(row, x)
    else:
        sample_uniform(arrays, random, x)


@kernel
def sample_uniform(arrays, random, x):  # type: ignore[no-untyped-def]
    """Draw a state (nx,) uniformly."""
    for i in range(x.shape[0]):
        low, high = arrays.lower[i], arrays.upper[i]
        x[i] = low + uniform(random) * (high - low)
    for k in range(arrays.spheres.shape[0]):
        first = arrays.spheres[k, 0]
        unit_vector(random, x[first : first + arrays.spheres[k, 1]])


@kernel
def sample_control(arrays, random, u):  # type: ignore[no-untyped-def]
    """Draw an input (nu,) uniformly."""
    for i in range(u.shape[0]):
        low, high = arrays.input_lower[i], arrays.input_upper[i]
        u[i] = low + uniform(random) * (high - low)


@kernel
def goal_violation(search, x, enough):  # type: ignore[no-untyped-def]
    """Return the normalised goal error of a state (nx,), as ``Goal.excess``.

    Evaluation stops early once it is known to exceed ``enough``.
    """
    goal = search.problem.goal
    far = state_violation(goal, x, enough)
    if (goal.point_body.shape[0] == 0 and goal.axis_body.shape[0] == 0) or not far <= enough:
        return far
    place_machine(search.machine, x, search.scratch)
    return body_violation(goal, search.scratch.poses, far)


@kernel
def is_inside(violation):  # type: ignore[no-untyped-def]
    """Whether a state of that normalised goal error counts as inside the goal."""
    return violation <= SEARCHED_FRACTION
