"""A problem as arrays: limits, metric, goal and what is in the way, for compiled code."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.numerics.jit import kernel
from kinolab.numerics.kd_forest import Array, Integers
from kinolab.numerics.rng import attitude, below, uniform
from kinolab.problem import Problem
from kinolab.search.tree.limits import LimitArrays, limit_arrays
from kinolab.simulation.collision_context import place_machine

GOAL_SAMPLES = 4096  # states around the goal that are drawn beforehand
GOAL_STATES = 256  # states in the goal

LARGEST, SUM, EUCLIDEAN = range(3)
NORMS = {"max": LARGEST, "sum": SUM, "euclidean": EUCLIDEAN}


class GoalArrays(NamedTuple):
    """Targets and tolerances; angles are judged the short way."""

    entry: Integers  # (named,) entries of the state
    target: Array  # (named,)
    tolerance: Array  # (named,)
    circular: NDArray[np.bool_]  # (named,)
    attitude: Integers  # (attitudes,) where their quaternions begin
    quaternion: Array  # (attitudes, 4)
    turn: Array  # (attitudes,) tolerances in [rad]
    point_body: Integers  # (points,)
    point_at: Array  # (points, 3) in the body's frame
    point_target: Array  # (points, 3)
    point_tolerance: Array  # (points,)
    axis_body: Integers  # (axes,)
    axis: Array  # (axes, 3) in the body's frame
    axis_target: Array  # (axes, 3)
    axis_tolerance: Array  # (axes,) in [rad]
    norm: int  # what counts of all shares: LARGEST, SUM or EUCLIDEAN


class ProblemArrays(NamedTuple):
    """What a search needs to know of a problem."""

    start: Array  # (nx,)
    limits: LimitArrays
    lower: Array  # (nx,) finite limits, within which states are drawn
    upper: Array  # (nx,)
    attitudes: Integers  # (attitudes,) where quaternions begin in the state
    input_lower: Array  # (nu,)
    input_upper: Array  # (nu,)
    entry: Integers  # (d,) entries of the state that the metric counts
    weight: Array  # (d,)
    circular: NDArray[np.bool_]  # (d,)
    goal: GoalArrays
    goal_samples: Array  # (states, nx) around the goal
    goal_states: Array  # (states, nx) in the goal
    step: float  # of propagation, in [s]


def gather_problem(problem: Problem, goal_region_scale: float, seed: int) -> ProblemArrays:
    """Gather what a search needs; goal samples reach ``goal_region_scale`` tolerances."""
    model, random = problem.model, np.random.default_rng(seed)
    entry = np.flatnonzero(problem.weights > 0)
    spreads = goal_region_scale ** random.uniform(size=GOAL_SAMPLES)
    return ProblemArrays(
        start=np.clip(problem.start, *problem.bounds.T),
        limits=limit_arrays(problem),
        lower=_row(problem.sampling_bounds[:, 0]),
        upper=_row(problem.sampling_bounds[:, 1]),
        attitudes=np.array(list(model.attitudes.values()), dtype=np.int64),
        input_lower=_row(model.control_bounds[:, 0]),
        input_upper=_row(model.control_bounds[:, 1]),
        entry=entry.astype(np.int64),
        weight=_row(problem.weights[entry]),
        circular=np.ascontiguousarray(problem.circular[entry]),
        goal=gather_goal(problem),
        goal_samples=problem.sample_goals(random, spreads),
        goal_states=problem.sample_goals(random, np.ones(GOAL_STATES)),
        step=problem.step,
    )


def metric_periods(arrays: ProblemArrays) -> Array:
    """Return after how much each scaled coordinate comes round, shape (d,)."""
    return np.where(arrays.circular, 2 * np.pi * arrays.weight, np.inf)


def gather_goal(problem: Problem) -> GoalArrays:
    """Return a problem's goal as arrays."""
    goal = problem.goal

    def rows(things: Any, name: str, width: int) -> Array:
        return np.array([getattr(thing, name) for thing in things], dtype=float).reshape(-1, width)

    def column(things: Any, name: str) -> Array:
        return np.array([getattr(thing, name) for thing in things], dtype=float)

    def whole(things: Any, name: str) -> Integers:
        return np.array([getattr(thing, name) for thing in things], dtype=np.int64)

    return GoalArrays(
        entry=np.array(goal.indices, dtype=np.int64),
        target=_row(goal.targets),
        tolerance=_row(goal.tolerances),
        circular=np.ascontiguousarray(goal.circular, dtype=bool),
        attitude=whole(goal.attitudes, "index"),
        quaternion=rows(goal.attitudes, "target", 4),
        turn=column(goal.attitudes, "tolerance"),
        point_body=whole(goal.points, "body"),
        point_at=rows(goal.points, "at", 3),
        point_target=rows(goal.points, "position", 3),
        point_tolerance=column(goal.points, "tolerance"),
        axis_body=whole(goal.directions, "body"),
        axis=rows(goal.directions, "axis", 3),
        axis_target=rows(goal.directions, "target", 3),
        axis_tolerance=column(goal.directions, "tolerance"),
        norm=NORMS[goal.norm],
    )


def _row(values: Array) -> Array:
    return np.ascontiguousarray(values, dtype=float)


wrapped_angle = kernel(wrapped)


@kernel
def metric_coordinates(arrays, x, out):  # type: ignore[no-untyped-def]
    """Write the coordinates (d,) that the metric counts, scaled, angles wrapped."""
    for i in range(arrays.entry.shape[0]):
        value = x[arrays.entry[i]]
        if arrays.circular[i]:
            value = wrapped_angle(value)
        out[i] = arrays.weight[i] * value


@kernel
def sample_state(arrays, random, bias, x):  # type: ignore[no-untyped-def]
    """Draw a state: with probability ``bias`` around the goal, else anywhere."""
    if uniform(random) < bias:
        row = arrays.goal_samples[below(random, arrays.goal_samples.shape[0])]
        for i in range(x.shape[0]):
            x[i] = row[i]
    else:
        sample_uniform(arrays, random, x)


@kernel
def sample_uniform(arrays, random, x):  # type: ignore[no-untyped-def]
    """Draw a state, all alike."""
    for i in range(x.shape[0]):
        low, high = arrays.lower[i], arrays.upper[i]
        x[i] = low + uniform(random) * (high - low)
    for k in range(arrays.attitudes.shape[0]):
        first = arrays.attitudes[k]
        attitude(random, x[first : first + 4])


@kernel
def sample_control(arrays, random, u):  # type: ignore[no-untyped-def]
    """Draw an input, all alike."""
    for i in range(u.shape[0]):
        low, high = arrays.input_lower[i], arrays.input_upper[i]
        u[i] = low + uniform(random) * (high - low)


@kernel
def normalized_error(goal, k, x):  # type: ignore[no-untyped-def]
    """Return how far a named entry is from its target, as a share of its tolerance."""
    gap = x[goal.entry[k]] - goal.target[k]
    return (wrapped_angle(gap) if goal.circular[k] else gap) / goal.tolerance[k]


@kernel
def goal_violation(search, x, enough):  # type: ignore[no-untyped-def]
    """Return how far outside the goal a state is, in tolerances, as ``GoalArrays.goal_violation``.

    Once it is known to be more than ``enough``, the rest is not looked at.
    """
    goal, far = search.problem.goal, 0.0
    for k in range(goal.entry.shape[0]):
        far = larger_violation(goal, far, abs(normalized_error(goal, k, x)))
        if not far <= enough:  # NaN included
            return far
    for k in range(goal.attitude.shape[0]):
        first, along = goal.attitude[k], 0.0
        for i in range(4):
            along += goal.quaternion[k, i] * x[first + i]
        far = larger_violation(goal, far, 2.0 * math.acos(min(1.0, abs(along))) / goal.turn[k])
    if (goal.point_body.shape[0] == 0 and goal.axis_body.shape[0] == 0) or not far <= enough:
        return far
    place_machine(search.machine, x, search.scratch)
    return body_goal_violation(goal, search.scratch, far)


@kernel
def larger_violation(goal, far, error):  # type: ignore[no-untyped-def]
    """Return how far outside the goal a state is, one more share counted; NaN stays NaN."""
    if goal.norm == EUCLIDEAN:
        return math.sqrt(far * far + error * error)
    if goal.norm == SUM:
        return far + abs(error)
    return far if error <= far or math.isnan(far) else error


@kernel
def body_goal_violation(goal, scratch, far):  # type: ignore[no-untyped-def]
    """Count the shares of points and axes at poses; see ``GoalArrays.goal_violation``."""
    for k in range(goal.point_body.shape[0]):
        pose, square = scratch.poses[goal.point_body[k]], 0.0
        for i in range(3):
            gap = pose[4 * i + 3] - goal.point_target[k, i]
            for j in range(3):
                gap += pose[4 * i + j] * goal.point_at[k, j]
            square += gap * gap
        far = larger_violation(goal, far, math.sqrt(square) / goal.point_tolerance[k])
    for k in range(goal.axis_body.shape[0]):
        pose, square = scratch.poses[goal.axis_body[k]], 0.0
        for i in range(3):
            turned = 0.0
            for j in range(3):
                turned += pose[4 * i + j] * goal.axis[k, j]
            gap = turned - goal.axis_target[k, i]
            square += gap * gap
        # The chord is sharp where the cosine is not.
        angle = 2.0 * math.asin(min(1.0, 0.5 * math.sqrt(square)))
        far = larger_violation(goal, far, angle / goal.axis_tolerance[k])
    return far
