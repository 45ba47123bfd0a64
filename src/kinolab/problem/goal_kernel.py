"""Goal errors in compiled code, with the arithmetic of ``Goal.errors``."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel
from kinolab.numerics.manifolds.state_parts import sphere_table
from kinolab.problem.goal import Goal

LARGEST, SUM, EUCLIDEAN = range(3)
NORMS = {"max": LARGEST, "sum": SUM, "euclidean": EUCLIDEAN}


class GoalArrays(NamedTuple):
    """Targets and tolerances of a goal; circular errors take the shorter arc."""

    entry: Integers  # (named,) entries of the state
    target: Array  # (named,)
    tolerance: Array  # (named,)
    circular: NDArray[np.bool_]  # (named,)
    sphere: Integers  # (parts, 3), as ``sphere_table``
    vector: Array  # (parts, 4), unit vectors and zeros after them
    angle: Array  # (parts,) tolerances in [rad]
    point_body: Integers  # (points,)
    point_at: Array  # (points, 3) in the body's frame
    point_target: Array  # (points, 3)
    point_tolerance: Array  # (points,)
    axis_body: Integers  # (axes,)
    axis: Array  # (axes, 3) in the body's frame
    axis_target: Array  # (axes, 3)
    axis_tolerance: Array  # (axes,) in [rad]
    norm: int  # of the normalized errors: LARGEST, SUM or EUCLIDEAN


def goal_arrays(goal: Goal) -> GoalArrays:
    """Return a goal as arrays."""

    def column(things: Any, name: str, *width: int, dtype: type = float) -> NDArray[Any]:
        values = [getattr(thing, name) for thing in things]
        return np.array(values, dtype=dtype).reshape(-1, *width)

    points = (*goal.points, *goal.formulas)
    return GoalArrays(
        entry=np.array(goal.indices, dtype=np.int64),
        target=np.ascontiguousarray(goal.targets, dtype=float),
        tolerance=np.ascontiguousarray(goal.tolerances, dtype=float),
        circular=np.ascontiguousarray(goal.circular, dtype=bool),
        sphere=sphere_table([one.part for one in goal.parts]),
        vector=np.array([(*one.target, 0.0)[:4] for one in goal.parts]).reshape(-1, 4),
        angle=column(goal.parts, "tolerance"),
        point_body=column(points, "body", dtype=np.int64),
        point_at=column(points, "at", 3),
        point_target=column(points, "position", 3),
        point_tolerance=column(points, "tolerance"),
        axis_body=column(goal.directions, "body", dtype=np.int64),
        axis=column(goal.directions, "axis", 3),
        axis_target=column(goal.directions, "target", 3),
        axis_tolerance=column(goal.directions, "tolerance"),
        norm=NORMS[goal.norm],
    )


wrapped_angle = kernel(wrapped)


@kernel
def normalized_error(goal, k, x):  # type: ignore[no-untyped-def]
    """Return the error of the k-th state target divided by its tolerance."""
    gap = x[goal.entry[k]] - goal.target[k]
    return (wrapped_angle(gap) if goal.circular[k] else gap) / goal.tolerance[k]


@kernel
def state_violation(goal, x, enough):  # type: ignore[no-untyped-def]
    """Return the goal violation of a state (nx,) in tolerances, without points and axes.

    Returns early once it exceeds ``enough``.
    """
    far = 0.0
    for k in range(goal.entry.shape[0]):
        far = add_violation(goal, far, abs(normalized_error(goal, k, x)))
        if not far <= enough:  # NaN included
            return far
    for k in range(goal.sphere.shape[0]):
        far = add_violation(goal, far, angle_from_target(goal, k, x) / goal.angle[k])
    return far


@kernel
def state_fractions(goal, x, reach, out):  # type: ignore[no-untyped-def]
    """Write the errors of a state (nx,) in tolerances, those of targets signed, without points.

    Args:
        goal: ``GoalArrays``.
        x: The state.
        reach: Largest error of interest; say whether none is larger.
        out: Of targets and of unit vectors, shape (named + parts,); written up to that.
    """
    named = goal.entry.shape[0]
    for k in range(out.shape[0]):
        if k < named:
            out[k] = normalized_error(goal, k, x)
        else:
            out[k] = angle_from_target(goal, k - named, x) / goal.angle[k - named]
        if not abs(out[k]) <= reach:  # NaN included
            return False
    return True


@kernel
def angle_from_target(goal, k, x):  # type: ignore[no-untyped-def]
    """Return the angle in [rad] between a unit vector and its target, as its part has it."""
    first, size, antipodal = goal.sphere[k, 0], goal.sphere[k, 1], goal.sphere[k, 2]
    apart, together = 0.0, 0.0
    for i in range(size):
        apart += (x[first + i] - goal.vector[k, i]) ** 2
        together += (x[first + i] + goal.vector[k, i]) ** 2
    if antipodal:  # the angle of a turn is twice that of quaternions
        return 4.0 * math.atan2(math.sqrt(min(apart, together)), math.sqrt(max(apart, together)))
    return 2.0 * math.atan2(math.sqrt(apart), math.sqrt(together))


@kernel
def add_violation(goal, far, error):  # type: ignore[no-untyped-def]
    """Add one normalized error to a goal violation; NaN propagates."""
    if goal.norm == EUCLIDEAN:
        return math.sqrt(far * far + error * error)
    if goal.norm == SUM:
        return far + abs(error)
    return far if error <= far or math.isnan(far) else error


@kernel
def body_violation(goal, poses, far):  # type: ignore[no-untyped-def]
    """Add the normalized errors of points and axes at poses (bodies, 12) to ``far``."""
    for k in range(goal.point_body.shape[0]):
        pose, square = poses[goal.point_body[k]], 0.0
        for i in range(3):
            gap = pose[4 * i + 3] - goal.point_target[k, i]
            for j in range(3):
                gap += pose[4 * i + j] * goal.point_at[k, j]
            square += gap * gap
        far = add_violation(goal, far, math.sqrt(square) / goal.point_tolerance[k])
    for k in range(goal.axis_body.shape[0]):
        angle = axis_angle(poses[goal.axis_body[k]], goal.axis[k], goal.axis_target[k])
        far = add_violation(goal, far, angle / goal.axis_tolerance[k])
    return far


@kernel
def axis_angle(pose, axis, target):  # type: ignore[no-untyped-def]
    """Return the angle in [rad] between a body's axis at a pose (12,) and a target (3,)."""
    a0, a1, a2 = carried(pose, axis, 0), carried(pose, axis, 1), carried(pose, axis, 2)
    c0 = a1 * target[2] - a2 * target[1]
    c1 = a2 * target[0] - a0 * target[2]
    c2 = a0 * target[1] - a1 * target[0]
    along = a0 * target[0] + a1 * target[1] + a2 * target[2]
    return math.atan2(math.sqrt(c0 * c0 + c1 * c1 + c2 * c2), along)


@kernel
def carried(pose, axis, i):  # type: ignore[no-untyped-def]
    """Return the i-th world component of a body axis (3,) at a pose (12,)."""
    return pose[4 * i] * axis[0] + pose[4 * i + 1] * axis[1] + pose[4 * i + 2] * axis[2]
