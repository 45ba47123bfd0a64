"""Configuration space of a machine at rest, for OMPL's geometric planners."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from typing import Any

import numpy as np
from ompl import base as ob

from kinolab.concurrency.cancel import (
    CancellationToken,
    CancelledError,
    never_cancelled,
    raise_if_cancelled,
)
from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.search.ompl.spaces import subspace
from kinolab.simulation import Propagator, Rejections
from kinolab.steering import Steering, cyclic_coordinates, nearest_equilibrium
from kinolab.world.geometry import reach_of

MIN_CHECKS = 12  # first samples of a path, which also give its length
CHECK_RESOLUTION = 0.02  # [m] between samples of a path
STATE_TOLERANCE = 1e-6  # [m] or [rad] between the goal and its round trip through OMPL
REST_SHIFT = 0.05  # of a coordinate's scale: shift to test whether an equilibrium keeps it


class ConfigurationSpace:
    """Equilibria, parametrised by the coordinates that equilibrium leaves free.

    If it leaves none free, for example because the start cannot be held, the dimension is zero.

    It must not refer to OMPL's space information, which refers to it.

    Args:
        problem: The planning problem.
        steering: Supplies paths between configurations.
        goal: Goal state, shape (nx,).
        margin: Required clearance in [m]; at most half that of start and goal.
        rejections: Counts rejected states.
        stop: Cancellation token: OMPL then finds no valid states, other callers get a
            CancelledError.

    Attributes:
        space: OMPL's compound space of the free coordinates.
        stop: Cancellation token.
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
        checker, ends = problem.checker(), (problem.start, goal)
        clearances = [checker.clearance(*problem.placement(x)) for x in ends]
        self._margin = min(margin, *(clearance / 2 for clearance in clearances))
        self._judge = Propagator(problem, self._margin, rejections)
        self._base = _base(problem, steering)
        self._free = _free(problem, steering, self._base)
        self._reach = [reach_of(body) for body in problem.bodies]
        self.space = ob.CompoundStateSpace()
        owners, bounds = problem.space.owners, problem.sampling_bounds
        lines = [subspace(owners[i], bounds[[i]]) for i in self._free]
        self._read = [read for _, _, read in lines]
        for i, (line, _, _) in zip(self._free, lines, strict=True):
            self.space.addSubspace(line, float(problem.weights[i]))
        self.space.lock()
        if self._free:  # OMPL rejects a space without extent
            self.space.setup()

    @property
    def differ(self) -> bool:
        """Whether its dimension is positive; OMPL cannot handle a space of dimension zero."""
        return bool(self._free)

    def write(self, state: Any, x: Array) -> None:
        """Set an OMPL state from a machine's state, shape (nx,)."""
        values = [float(x[i]) for i in self._free]
        for k, i in enumerate(self._free):
            if self._problem.circular[i]:
                values[k] = float(wrapped(values[k]))
        self.space.copyFromReals(state, values)

    def read(self, state: Any) -> Array | None:
        """Return the equilibrium of an OMPL state, shape (nx,); None if there is none."""
        x = self._base.copy()
        for k, i in enumerate(self._free):
            self._read[k](state[k], (i,), x)
        settled = nearest_equilibrium(self._problem, x)
        return None if settled is None else settled[0]

    def is_valid(self, state: Any) -> bool:
        """Say whether there is an equilibrium with enough clearance."""
        x = None if self.stop() else self.read(state)
        try:
            return x is not None and self.has_clearance(x)
        except CancelledError:
            return False

    def has_clearance(self, x: Array) -> bool:
        """Say whether a state, shape (nx,), is within limits and has enough clearance."""
        raise_if_cancelled(self.stop)
        return self._judge.admits(x.tolist())

    def free_paths(self, x0: Array, x1: Array) -> Iterator[list[Any]]:
        """Yield collision-free connections between two equilibria, each a list of paths.

        Detours are tried only into the goal, where clearance is smallest.
        """
        family = self._steering.family
        found = family.paths(x0, x1)
        for paths in chain(found, family.detours(x0, x1)) if self._is_goal(x1) else found:
            if all(self._has_clearance_along(path, x0) for path in reversed(paths)):
                yield paths

    def joined(self, x0: Array, x1: Array) -> bool:
        """Say whether two equilibria can be connected; the goal is taken as the end."""
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
        """Bound the distance in [m] that any point moves along states, shape (n, nx)."""
        order = np.argsort(np.linalg.norm(states - states[-2], axis=1), kind="stable")
        poses = self._problem.frames(states[order]).reshape(len(states), -1, 3, 4)
        moved = np.linalg.norm(np.diff(poses[..., 3], axis=0), axis=-1)
        turned = np.linalg.norm(np.diff(poses[..., :3], axis=0), axis=(-2, -1))
        return float((moved + turned * self._reach).sum(axis=0).max())


class PathValidator(ob.MotionValidator):  # type: ignore[misc]
    """Connects two configurations if the path family has a collision-free path."""

    def __init__(self, space_information: Any, configurations: ConfigurationSpace) -> None:
        super().__init__(space_information)
        self._configurations = configurations

    def checkMotion(self, begin: Any, end: Any, *_: Any) -> bool:
        """Say whether there is a collision-free path."""
        x0, x1 = (self._configurations.read(state) for state in (begin, end))
        try:
            return x0 is not None and x1 is not None and self._configurations.joined(x0, x1)
        except CancelledError:
            return False


def _base(problem: PlanningTask, steering: Steering) -> Array:
    """Return the equilibrium near the start with cyclic coordinates at zero, shape (nx,)."""
    x = np.where(cyclic_coordinates(problem), 0.0, steering.family.straightened(problem.start))
    settled = nearest_equilibrium(problem, x)
    return x if settled is None else settled[0]


def _free(problem: PlanningTask, steering: Steering, base: Array) -> list[int]:
    """Return the coordinates that equilibrium leaves free: not cable sway, not wheel rotation."""
    found = []
    for i in np.flatnonzero(~cyclic_coordinates(problem))[: problem.model.nq].tolist():
        shifted = base.copy()
        lower, upper = problem.sampling_bounds[i]
        inward = 1.0 if base[i] < (lower + upper) / 2 else -1.0
        shifted[i] += inward * REST_SHIFT * problem.scales[i]
        settled = nearest_equilibrium(problem, steering.family.straightened(shifted))
        if i < problem.model.nq and settled is not None:
            kept = abs(settled[0][i] - shifted[i]) < REST_SHIFT * problem.scales[i] / 2
            found += [i] if kept else []
    return found
