"""What could go wrong first in a tube: a contact, a limit that is passed, a goal that is missed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.interval_analysis.interval_series import products
from kinolab.numerics.intervals import IntervalArray
from kinolab.problem import PlanningTask
from kinolab.problem.goal import DirectionTarget, Goal, PointTarget
from kinolab.verification.tube.reachability import Tube
from kinolab.verification.tube.tube_poses import TubePoses, moved_by


@dataclass(frozen=True)
class Hazard:
    """Something that is not excluded.

    Attributes:
        time: When it could happen first, in [s].
        what: In words.
    """

    time: float
    what: str


def limit_hazards(problem: PlanningTask, tube: Tube, poses: TubePoses) -> Iterator[Hazard]:
    """Yield what could leave its limits: coordinates, the workspace, axes that look into cones.

    Limits of coordinates are the machine's own: those of [bounds] are a planner's reserve. Limits
    of speeds are not looked at.
    """
    model, t = problem.whole or problem.model, tube.nominal.t
    counts = np.ones(model.nx, dtype=bool)
    counts[model.speeds] = False
    for part in problem.space.spheres:  # unit vectors, of which nothing else is limited
        counts[part.own] = False
    for i in np.flatnonzero(counts & ~problem.circular):
        lower, upper = model.state_bounds[i]
        low, high = poses.states.low[i], poses.states.high[i]
        yield from _outside(model.state_names[i], low, high, (lower, upper), t)
    for axis, limits in problem.world.bounds.items():
        entry = "xyz".index(axis) * 4 + 3
        for body in problem.moving:
            low, high = poses.frames.low[body, entry], poses.frames.high[body, entry]
            yield from _outside(f"{axis} of {problem.bodies[body].name}", low, high, limits, t)
    for cone in (cone.forbidden for cone in problem.keep_outs):
        size = np.cos(cone.half_angle)
        along = _dot(poses, cone.body, cone.axis, cone.direction)
        for k in np.flatnonzero(~(along <= size).all(axis=1))[:1]:
            name = problem.bodies[cone.body].name
            yield Hazard(float(t[k]), f"the axis of {name} could look into the forbidden cone")


def _outside(
    name: str, low: Array, high: Array, limits: tuple[float, float], t: Array
) -> Iterator[Hazard]:
    """Yield when a value (steps, parts) could first be outside its limits."""
    inside = (low >= limits[0] - 1e-9) & (high <= limits[1] + 1e-9)  # as plans are checked
    for k in np.flatnonzero(~inside.all(axis=1))[:1]:
        below = (low[k] < limits[0]).any()
        side, limit = ("below", limits[0]) if below else ("above", limits[1])
        value = low[k].min() if below else high[k].max()
        yield Hazard(float(t[k]), f"{name} could be {side} {limit:.4g}: {value:.4g}")


def _dot(
    poses: TubePoses,
    body: int,
    axis: tuple[float, float, float],
    direction: tuple[float, float, float],
) -> Array:
    """Return the largest cosine between an axis of a body and a direction, (steps, parts)."""
    shape = (3, 4, *poses.frames.low.shape[2:])
    rows = tuple(e[body].reshape(shape)[:, :3] for e in (poses.frames.low, poses.frames.high))
    factors = np.einsum("i,j->ij", direction, axis)[:, :, None, None]
    return np.asarray(products(rows, (factors, factors))[1].sum(axis=(0, 1)))


def wrapping_hazards(problem: PlanningTask, tube: Tube, noise: Array) -> Iterator[Hazard]:
    """Yield where a deviation is so large that its sign is ambiguous: of circles and attitudes.

    Args:
        tube: Deviations from the nominal motion.
        noise: By how much measurements are off at most, shape (nx,).
    """
    bounds, t = tube.bounds, tube.nominal.t
    # 1e-6 of a scale: by how much nominal states may differ from the plan's
    size = np.maximum(np.abs(bounds.low), np.abs(bounds.high)) + noise + 1e-6 * problem.scales
    far = (size[:, problem.circular] >= np.pi).any(axis=1)
    for part in problem.space.spheres:  # chords longer than 1 are of turns beyond 1 rad
        far |= np.linalg.norm(size[:, part.own], axis=1) >= 1.0
    for k in np.flatnonzero(far)[:1]:
        yield Hazard(float(t[k]), "an angle could be off by so much that its sign is ambiguous")


def goal_excess(problem: PlanningTask, tube: Tube, poses: TubePoses) -> float:
    """Return how far the end of a tube is from the goal at most, in tolerances of the plan.

    The plan's [goal] reserve is left to what is carried out.
    """
    return min((_excess(problem, goal, tube, poses) for goal in problem.goal.each), default=np.inf)


def _excess(problem: PlanningTask, goal: Goal, tube: Tube, poses: TubePoses) -> float:
    end, off = tube.nominal.x[-1], tube.bounds
    size = np.maximum(np.abs(off.low[-1]), np.abs(off.high[-1]))
    if goal.predicate is not None:
        return float("inf")  # nothing is known of it
    frames = problem.model.frames(end) if goal.needs_frames else None
    errors = np.abs(goal.errors(end, frames))
    extra = [size[i] for i in goal.indices]
    for one in goal.parts:  # a chord of attitudes is 2 sin(angle / 4) long
        chord = min(float(np.linalg.norm(size[one.part.own])), 2.0)
        extra.append(2.0 * one.part.angles * np.arcsin(chord / 2.0))
    for target in goal.of_bodies:
        extra.append(_off(target, poses))
    shares = (errors + np.array(extra)) / goal.error_tolerances
    if goal.norm == "euclidean":
        return float(np.linalg.norm(shares))
    return float(shares.sum() if goal.norm == "sum" else shares.max(initial=0.0))


def _off(target: PointTarget | DirectionTarget, poses: TubePoses) -> float:
    """Return how far a point is off at most in [m], or an axis in [rad], in the last step."""
    change = IntervalArray(
        poses.change.low[target.body][:, -1:], poses.change.high[target.body][:, -1:]
    )
    if isinstance(target, PointTarget):
        return float(moved_by(change, np.array(target.at), 1.0).max())
    chord = min(float(moved_by(change, np.array(target.axis), 0.0).max()), 2.0)
    return float(2.0 * np.arcsin(chord / 2.0))
