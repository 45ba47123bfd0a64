"""The configurations in which a machine can stay, as a space for OMPL's geometric planners."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from typing import Any

import numpy as np
from ompl import base as ob

from kinolab.cancel import CancellationToken, CancelledError, never_cancelled, raise_if_cancelled
from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation import Propagator, Rejections
from kinolab.steering import Steering, cyclic_coordinates, nearest_equilibrium
from kinolab.world.geometry import placement, sizes

MIN_CHECKS = 12  # looks at a path, which tell how long it is
CHECK_RESOLUTION = 0.02  # [m] between two looks at a path
STATE_TOLERANCE = 1e-6  # [m] or [rad] between the goal and itself, read back from OMPL
REST_SHIFT = 0.05  # of a coordinate's scale: a change that rest may undo


class ConfigurationSpace:
    """States at rest, told apart by the coordinates that rest leaves free.

    Where rest leaves nothing free, as where the start cannot be held, it has no dimension.

    It does not refer to OMPL's space information, which refers to it.

    Args:
        problem: Whose machine and world.
        steering: Knows the ways between two of them.
        goal: Where it shall end, shape (nx,).
        margin: Room in [m] that is asked for beside obstacles; half of what start and goal have
            where that is less.
        rejections: Where to count what is refused.
        stop: Says that looking for ways must end: OMPL finds nothing any more, others get a
            CancelledError.

    Attributes:
        space: OMPL's compound space of the free coordinates.
        stop: As given.
    """

    def __init__(
        self,
        problem: PlanningTask,
        steering: Steering,
        goal: Array,
        margin: float,
        rejections: Rejections | None = None,
        stop: CancellationToken = never_cancelled,
    ) -> None:
        self._problem, self._steering, self._goal = problem, steering, goal
        self.stop = stop
        self._margin = min(margin, *(_room(problem, x) / 2 for x in (problem.start, goal)))
        self._judge = Propagator(problem, self._margin, rejections)
        self._base = _base(problem, steering)
        self._free = _free(problem, steering, self._base)
        self._reach = [_reach(body) for body in problem.bodies]
        self.space = ob.CompoundStateSpace()
        for i in self._free:
            self.space.addSubspace(_line(problem, i), float(problem.weights[i]))
        self.space.lock()
        if self._free:  # OMPL refuses a space without extent
            self.space.setup()

    @property
    def differ(self) -> bool:
        """Whether there is more than one; OMPL has no use for a space of no dimension."""
        return bool(self._free)

    def write(self, state: Any, x: Array) -> None:
        """Set an OMPL state from a machine's state."""
        values = [float(x[i]) for i in self._free]
        for k, i in enumerate(self._free):
            if self._problem.circular[i]:
                values[k] = float(wrapped(values[k]))
        self.space.copyFromReals(state, values)

    def read(self, state: Any) -> Array | None:
        """Return the machine's state at rest; None where it cannot stay."""
        x = self._base.copy()
        for k, i in enumerate(self._free):
            x[i] = state[k].value if self._problem.circular[i] else state[k][0]
        settled = nearest_equilibrium(self._problem, x)
        return None if settled is None else settled[0]

    def is_valid(self, state: Any) -> bool:
        """Say whether the machine can stay there and has room."""
        x = None if self.stop() else self.read(state)
        try:
            return x is not None and self.has_clearance(x)
        except CancelledError:
            return False

    def has_clearance(self, x: Array) -> bool:
        """Say whether a state keeps its limits and has room around it."""
        raise_if_cancelled(self.stop)
        return self._judge.admits(x.tolist())

    def free_paths(self, x0: Array, x1: Array) -> Iterator[list[Any]]:
        """Yield the free ways from one state at rest to another, each a list of paths.

        Longer ways are tried into the goal alone: where there is least room, and once for all.
        """
        ways = self._steering.ways
        found = ways.paths(x0, x1)
        for paths in chain(found, ways.detours(x0, x1)) if self._is_goal(x1) else found:
            if all(self._has_clearance_along(path, x0) for path in reversed(paths)):
                yield paths

    def joined(self, x0: Array, x1: Array) -> bool:
        """Say whether there is a free way between two states at rest; the goal is an end."""
        ends = (x1, x0) if self._is_goal(x0) else (x0, x1)
        return any(True for _ in self.free_paths(*ends))

    def _is_goal(self, x: Array) -> bool:
        away = x[self._free] - self._goal[self._free]
        away = np.where(self._problem.circular[self._free], wrapped(away), away)
        return bool(np.abs(away).max(initial=0.0) < STATE_TOLERANCE)

    def _has_clearance_along(self, path: Any, x0: Array) -> bool:
        raise_if_cancelled(self.stop)
        motion = self._steering.paths
        assert motion is not None
        few = motion.sample_states(path, x0, MIN_CHECKS)
        if not all(map(self.has_clearance, few)):
            return False
        count = int(np.ceil(self._length(few) / max(self._margin, CHECK_RESOLUTION)))
        return count <= MIN_CHECKS or all(
            map(self.has_clearance, motion.sample_states(path, x0, count))
        )

    def _length(self, states: Array) -> float:
        """Return how far a point moves at most between the first and the last of some states."""
        order = np.argsort(np.linalg.norm(states - states[-2], axis=1), kind="stable")
        poses = self._problem.frames(states[order]).reshape(len(states), -1, 3, 4)
        moved = np.linalg.norm(np.diff(poses[..., 3], axis=0), axis=-1)
        turned = np.linalg.norm(np.diff(poses[..., :3], axis=0), axis=(-2, -1))
        return float((moved + turned * self._reach).sum(axis=0).max())


class PathValidator(ob.MotionValidator):  # type: ignore[misc]
    """Joins two configurations where the machine knows a free way."""

    def __init__(self, space_information: Any, configurations: ConfigurationSpace) -> None:
        super().__init__(space_information)
        self._configurations = configurations

    def checkMotion(self, begin: Any, end: Any, *_: Any) -> bool:
        """Say whether there is one."""
        x0, x1 = (self._configurations.read(state) for state in (begin, end))
        try:
            return x0 is not None and x1 is not None and self._configurations.joined(x0, x1)
        except CancelledError:
            return False


def _base(problem: PlanningTask, steering: Steering) -> Array:
    """Return the state near the start in which the machine can stay, ignoring what may be."""
    x = np.where(cyclic_coordinates(problem), 0.0, steering.ways.straightened(problem.start))
    settled = nearest_equilibrium(problem, x)
    return x if settled is None else settled[0]


def _free(problem: PlanningTask, steering: Steering, base: Array) -> list[int]:
    """Return the coordinates that rest leaves free: not a rope's sway, not a wheel's rotation."""
    found = []
    for i in np.flatnonzero(~cyclic_coordinates(problem))[: problem.model.nq].tolist():
        shifted = base.copy()
        lower, upper = problem.sampling_bounds[i]
        inward = 1.0 if base[i] < (lower + upper) / 2 else -1.0
        shifted[i] += inward * REST_SHIFT * problem.scales[i]
        settled = nearest_equilibrium(problem, steering.ways.straightened(shifted))
        if i < problem.model.nq and settled is not None:
            kept = abs(settled[0][i] - shifted[i]) < REST_SHIFT * problem.scales[i] / 2
            found += [i] if kept else []
    return found


def _line(problem: PlanningTask, i: int) -> Any:
    if problem.circular[i]:
        return ob.SO2StateSpace()
    bounds, space = ob.RealVectorBounds(1), ob.RealVectorStateSpace(1)
    bounds.setLow(0, float(problem.sampling_bounds[i, 0]))
    bounds.setHigh(0, float(problem.sampling_bounds[i, 1]))
    space.setBounds(bounds)
    return space


def _room(problem: PlanningTask, x: Array) -> float:
    """Return how far every point may move from a state before anything touches, in [m]."""
    return problem.checker().clearance(*problem.placement(x))


def _reach(body: Any) -> float:
    """Return how far a body's points are from its origin at most, in [m]."""
    distances = [
        float(np.linalg.norm(placement(shape)[:, 3]) + np.linalg.norm(sizes(shape)[1]))
        for shape in body.shapes
    ]
    return max(distances, default=0.0)
