"""What marks the goal: a region, or the machine's outline, as far as the goal decides it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.show.scene.picture import Ghost, GoalMarker
from kinolab.world import BodyGeometry
from kinolab.world.shapes.geometry import frame_in_world


def goal_mark(problem: PlanningTask, x: Array) -> GoalMarker | Ghost | None:
    """Return the goal's marker: a ball or ring, or the machine at the goal; None if undefined.

    What the goal leaves free is as at the end of a motion. Before there is one, only those bodies
    are shown whose place the goal decides.

    Args:
        x: States along the way, shape (nt, nx); of a single one it is known that nothing moves.
    """
    goal, nq = problem.goal, problem.model.nq
    decided = [i for i in goal.entries if i < nq]
    if goal.points or goal.directions or not decided:
        return None  # balls and cones mark them; the rest of the pose is not determined
    state = goal.centre(x[-1])
    poses, ends = problem.placement(state)
    names = {problem.model.state_names[i] for i in decided}
    if names == {"x", "y"}:
        reach = dict(zip(goal.indices, goal.tolerances.tolist(), strict=True))
        px, py, pz = poses[problem.leading, 3::4].tolist()
        return GoalMarker((px, py, pz), float(min(reach[i] for i in decided)))
    ends = ends.reshape(-1, 2, 3)
    if len(x) == 1 and not problem.machine.closes_loops:  # loops decide what the goal does not
        free = [i for i in range(nq) if i not in decided]
        shown = _decided(problem, state, free)
        if not shown.any():
            return None
        poses = np.where(shown[:, None], poses, _point(poses[shown][0]))
        ends = ends if shown.all() else np.full_like(ends, np.nan)
    return Ghost(hidden_obstacles(problem, poses), ends)


def hidden_obstacles(problem: PlanningTask, poses: Array) -> Array:
    """Return poses (nb, 12) in which obstacles that move are points, which hides them."""
    hidden = np.array([body.prescribed for body in problem.bodies], dtype=bool)
    return np.where(hidden[:, None], _point(poses[problem.leading]), poses)


def _point(pose: Array) -> Array:
    return np.append(np.zeros((3, 3)), pose[3::4, None], axis=1).ravel()


def _decided(problem: PlanningTask, state: Array, free: Sequence[int]) -> NDArray[np.bool_]:
    """Return which bodies cover the same space whatever the free entries of a state are."""
    moved = np.repeat(state[None], len(free), axis=0)
    # 0.1 of the scales: how far free coordinates are moved, to see what moves with them
    moved[range(len(free)), free] += 0.1 * problem.scales[list(free)]
    rows = problem.model.frames(np.concatenate([state[None], moved]))
    return np.array([_still(body, rows[:, k]) for k, body in enumerate(problem.bodies)])


def _still(body: BodyGeometry, poses: Array) -> bool:
    """Whether a body covers the same space at poses of shape (n, 12), as far as its shapes go."""
    rows = poses.reshape(-1, 3, 4)
    parts = [(shape.symmetric, *frame_in_world(shape, rows)) for shape in body.shapes]
    for symmetric, axes, centre in parts or [("", rows[..., :3], rows[..., 3])]:
        kept = {"": axes, "z": axes[..., 2]}.get(symmetric, centre)
        # 1e-9 [m] and of unit vectors; what moves less stays where it is
        if any(float(np.abs(each - each[0]).max()) > 1e-9 for each in (kept, centre)):
            return False
    return True
