"""Cyclic coordinates: entries of the state that do not matter, such as how far a wheel rolled."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.analysis.invariants import RANDOM_STATES, change_by
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.world.shapes.geometry import placement

# Which axes of a shape's own frame its symmetry distinguishes.
SHOWN: dict[str, list[int]] = {"": [0, 1, 2], "z": [2], "xyz": []}


@lru_cache(maxsize=8)
def cyclic_coordinates(problem: PlanningTask) -> NDArray[np.bool_]:
    """Return which entries of the state affect neither dynamics nor collisions, shape (nx,).

    These are coordinates without limits or goals that are absent from the equations of motion and
    move no shape, except for spin about an axis of symmetry.
    """
    model = problem.model
    generator = np.random.default_rng(0)
    states = np.array([problem.sample_goal(generator) for _ in range(RANDOM_STATES)])
    u = _inputs(problem)
    slopes = np.abs(model.jacobian(states, u)[0]).max(axis=0)  # |df/dx|, largest over states
    # 1e-12 relative to the largest derivative
    sensitive = (slopes > 1e-12 * np.maximum(slopes.max(axis=1, keepdims=True), 1.0)).any(axis=0)
    wanted = set(problem.goal.entries)
    found = np.zeros(model.nx, dtype=bool)
    for i in range(model.nq):
        unbounded = problem.circular[i] or not np.isfinite(problem.bounds[i]).any()
        turned = model.space.turns[i] and not model.circular[i]  # part of an attitude
        bound = sensitive[i] or turned or i in wanted or not unbounded
        found[i] = not bound and not any(
            matters(problem, states, i) for matters in (_shows, _turns_what_is_aimed, _demands)
        )
    if problem.cost_entry is not None:
        found[problem.cost_entry] = True
    return found


def _inputs(problem: PlanningTask) -> Array:
    """Sample inputs: what steers a force shows only if the force is non-zero; shape (m, nu)."""
    lower, upper = problem.model.control_bounds.T
    return np.random.default_rng(1).uniform(lower, upper, (RANDOM_STATES, problem.model.nu))


def _changes(function: Callable[[Array], Array], states: Array, i: int) -> bool:
    return change_by(function, states, i, 1.0) > 1e-9  # [m] and [1]: rounding


def _demands(problem: PlanningTask, states: Array, i: int) -> bool:
    """Say whether the machine's requirements depend on an entry of the state."""
    u = _inputs(problem)
    asked = problem.machine.requirements
    return bool(asked) and _changes(lambda x: problem.model.requirements(x, u), states, i)


def _shows(problem: PlanningTask, states: Array, i: int) -> bool:
    """Say whether an entry of the state moves a shape, apart from spin about its symmetry axis."""
    if problem.cables and _changes(problem.model.cables, states, i):
        return True

    def shown(x: Array) -> Array:  # centres and axes of all shapes
        poses = problem.frames(x).reshape(len(x), -1, 3, 4)
        parts = [np.zeros((len(x), 0))]
        for k, body in enumerate(problem.bodies):
            turn, place = poses[:, k, :, :3], poses[:, k, :, 3]
            for shape in body.shapes:
                own = placement(shape)
                axes = turn @ own[:, SHOWN[shape.symmetric]]
                parts += [turn @ own[:, 3] + place, axes.reshape(len(x), -1)]
        return np.hstack(parts)

    return _changes(shown, states, i)


def _turns_what_is_aimed(problem: PlanningTask, states: Array, i: int) -> bool:
    """Say whether an entry of the state moves a body with goal points, axes or keep-out cones."""
    goal = problem.goal
    bodies = [point.body for point in goal.points]
    bodies += [axis.body for axis in goal.directions] + [cone.body for cone in problem.keep_outs]
    return bool(bodies) and _changes(lambda x: problem.frames(x)[:, bodies], states, i)
