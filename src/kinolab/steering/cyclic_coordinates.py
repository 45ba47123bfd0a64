"""Cyclic coordinates: entries of the state that do not matter, such as how far a wheel rolled."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.world.geometry import placement

RANDOM_STATES = 8  # random states to test at
MOTION_TOLERANCE = 1e-9  # [m] and [1]: rounding
ROUNDING = 1e-12  # relative to the largest derivative
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
    sensitive = (slopes > ROUNDING * np.maximum(slopes.max(axis=1, keepdims=True), 1.0)).any(axis=0)
    wanted = set(problem.goal.entries)
    found = np.zeros(model.nx, dtype=bool)
    for i in range(model.nq):
        unbounded = problem.circular[i] or not np.isfinite(problem.bounds[i]).any()
        turned = model.space.turns[i] and not model.circular[i]  # part of an attitude
        bound = sensitive[i] or turned or i in wanted or not unbounded
        found[i] = not bound and not any(
            matters(problem, states, i) for matters in (_shows, _turns_what_is_aimed, _demands)
        )
    return found


def _inputs(problem: PlanningTask) -> Array:
    """Sample inputs: what steers a force shows only if the force is non-zero; shape (m, nu)."""
    lower, upper = problem.model.control_bounds.T
    return np.random.default_rng(1).uniform(lower, upper, (RANDOM_STATES, problem.model.nu))


def _turned(states: Array, i: int) -> Array:
    turned = states.copy()
    turned[:, i] += 1.0
    return turned


def _demands(problem: PlanningTask, states: Array, i: int) -> bool:
    """Say whether the machine's requirements depend on an entry of the state."""
    if not problem.machine.requirements:
        return False
    u = _inputs(problem)
    before, after = (problem.model.requirements(x, u) for x in (states, _turned(states, i)))
    return bool(np.abs(after - before).max() > MOTION_TOLERANCE)


def _shows(problem: PlanningTask, states: Array, i: int) -> bool:
    """Say whether an entry of the state moves a shape, apart from spin about its symmetry axis."""
    cables = [problem.model.cables(x) for x in (states, _turned(states, i))]
    if problem.cables and np.abs(cables[1] - cables[0]).max() > MOTION_TOLERANCE:
        return True
    before, after = (
        problem.frames(x).reshape(RANDOM_STATES, -1, 3, 4) for x in (states, _turned(states, i))
    )
    for k, body in enumerate(problem.bodies):
        for shape in body.shapes:
            own = placement(shape)
            for a, b in zip(before[:, k], after[:, k], strict=True):
                centres = [pose[:, :3] @ own[:, 3] + pose[:, 3] for pose in (a, b)]
                turns = [(pose[:, :3] @ own[:, :3])[:, SHOWN[shape.symmetric]] for pose in (a, b)]
                if (
                    max(np.abs(np.subtract(*pair)).max(initial=0.0) for pair in (centres, turns))
                    > MOTION_TOLERANCE
                ):
                    return True
    return False


def _turns_what_is_aimed(problem: PlanningTask, states: Array, i: int) -> bool:
    """Say whether an entry of the state moves a body with goal points, axes or keep-out cones."""
    goal = problem.goal
    bodies = [point.body for point in goal.points]
    bodies += [axis.body for axis in goal.directions] + [cone.body for cone in problem.keep_outs]
    if not bodies:
        return False
    before, after = (problem.frames(x)[:, bodies] for x in (states, _turned(states, i)))
    return bool(np.abs(after - before).max() > MOTION_TOLERANCE)
