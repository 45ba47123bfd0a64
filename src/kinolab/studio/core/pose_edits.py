"""Poses of a machine by its coordinates and by its bodies, its constraints kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from kinolab.dynamics.analysis.consistent_states import nearest_consistent_state
from kinolab.loading import start_table
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.goal import DirectionTarget, Goal, PointTarget
from kinolab.problem.inverse_kinematics import reaching
from kinolab.studio.core.edits import DIGITS

LOOP_DIGITS = 12  # after the point, of machines whose loops must close to 1e-9


def with_entry(problem: PlanningTask, x: Array, name: str, value: float) -> Array:
    """Return a state with one entry changed, shape (nx,), and others as loops demand it."""
    changed = x.copy()
    changed[problem.model.state_names.index(name)] = value
    return _closed(problem, problem.model.space.unit(changed))


def with_body_at(
    problem: PlanningTask, x: Array, body: int, place: Array, turn: Array | None = None
) -> Array:
    """Return a state in which a body is as near to a place as its constraints let it, shape (nx,).

    Args:
        problem: The machine; wheels stay on the ground and loops closed.
        x: The state before, shape (nx,).
        place: Where its origin is wanted, shape (3,), in [m].
        turn: How it is wanted to be turned, shape (3, 3); as it is when left out.
    """
    directions: tuple[DirectionTarget, ...] = ()
    pose = problem.frames(x)[body].reshape(3, 4)
    # 1e-3 of unit vectors: a gizmo that is turned less was only moved
    if turn is not None and np.abs(turn - pose[:, :3]).max() > 1e-3:
        axes = zip(np.eye(3)[:2].tolist(), turn.T[:2].tolist(), strict=True)
        directions = tuple(DirectionTarget(body, tuple(a), tuple(b), 1.0) for a, b in axes)
    point = PointTarget(body, (0.0, 0.0, 0.0), tuple(place.tolist()), 1.0)
    nothing = replace(problem.goal, indices=(), targets=np.zeros(0), tolerances=np.zeros(0))
    goal: Goal = replace(
        nothing, circular=np.zeros(0, bool), parts=(), points=(point,), directions=directions
    )
    scales, limits = problem.model.state_scales, problem.bounds
    state, still = x, np.zeros((1, 1, 3))
    # 3 rounds in which a body is led to its place and loops are closed again
    for _ in range(3 if problem.machine.closes_loops else 1):
        led = reaching(problem.model, goal, state[None], still, scales=scales, limits=limits)[0]
        state = _closed(problem, led)
    return state


def _closed(problem: PlanningTask, x: Array) -> Array:
    if not (problem.machine.closes_loops or problem.machine.all_rates):
        return x
    near = nearest_consistent_state(problem.model, x, problem.bounds)
    return x if near is None else near


def written(problem: PlanningTask, before: Array, after: Array) -> dict[str, Any]:
    """Return the entries by which a state (nx,) differs from the one before, as one types them."""
    digits = LOOP_DIGITS if problem.machine.closes_loops else DIGITS
    old, new = start_table(problem.model, before), start_table(problem.model, after)
    # 1e-9 of entries: what differs less was not moved
    changed = {
        name: value
        for name, value in new.items()
        if np.abs(np.asarray(value) - np.asarray(old[name])).max() > 1e-9
    }
    return {name: _rounded(value, digits) for name, value in changed.items()}


def _rounded(value: Any, digits: int) -> Any:
    if isinstance(value, list):
        return [round(entry, LOOP_DIGITS) + 0.0 for entry in value]  # a unit vector
    return round(float(value), digits) + 0.0


def asked(problem: PlanningTask, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return those of changed entries that are coordinates, or that the goal asks for."""
    model = problem.model
    stated = {model.state_names[i] for i in problem.goal.entries}
    places = {*model.state_names[: model.nq], *(part.name for part in model.space.spheres)}
    return {name: value for name, value in changes.items() if name in stated | places}
