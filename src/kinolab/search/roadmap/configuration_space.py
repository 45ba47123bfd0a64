"""Configuration space of a machine at rest."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from typing import Any

import numpy as np

from kinolab.concurrency.cancel import CancellationToken, never_cancelled, raise_if_cancelled
from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation import Propagator, Rejections
from kinolab.steering import Steering, cyclic_coordinates, nearest_equilibrium
from kinolab.world.shapes.geometry import reach_of

MIN_CHECKS = 12  # first samples of a path, which also give its length
REST_SHIFT = 0.05  # of a coordinate's scale: shift to test whether an equilibrium keeps it


class ConfigurationSpace:
    """Equilibria, parametrised by the coordinates that equilibrium leaves free.

    If it leaves none free, for example because the start cannot be held, the dimension is zero.

    Args:
        steering: Supplies paths between configurations.
        goal: Goal state, shape (nx,).
        margin: Required clearance in [m]; at most half that of start and goal.
        rejections: Counts rejected states.
        stop: Cancellation token; cancelling raises a CancelledError.
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
        self._stop = stop
        checker, ends = problem.checker(), (problem.start, goal)
        clearances = [checker.clearance(*problem.placement(x)) for x in ends]
        self._margin = min(margin, *(clearance / 2 for clearance in clearances))
        self._judge = Propagator(problem, self._margin, rejections)
        self._base = _base(problem, steering)
        self._free = _free(problem, steering, self._base)
        self._reach = [reach_of(body) for body in problem.bodies]

    @property
    def differ(self) -> bool:
        """Whether its dimension is positive."""
        return bool(self._free)

    def equilibrium(self, x: Array) -> Array | None:
        """Return the equilibrium with a state's free coordinates, shape (nx,); None without one."""
        whole = self._base.copy()
        whole[self._free] = x[self._free]
        settled = nearest_equilibrium(self._problem, whole)
        return None if settled is None else settled[0]

    def draw(self, generator: np.random.Generator) -> Array | None:
        """Return a random equilibrium, shape (nx,); None if there is none of what was drawn."""
        return self.equilibrium(self._problem.sample(generator))

    def distances(self, x: Array, others: Array) -> Array:
        """Return weighted distances from one state (nx,) to others (m, nx), shape (m,)."""
        free = np.zeros(len(x))
        free[self._free] = self._problem.weights[self._free]
        return self._problem.space.distance(x, others, free)

    def has_clearance(self, x: Array) -> bool:
        """Say whether a state, shape (nx,), is within limits and has enough clearance."""
        raise_if_cancelled(self._stop)
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
        # [m] or [rad] between the goal and its round trip through OMPL
        return bool(np.abs(away).max(initial=0.0) < 1e-6)

    def _has_clearance_along(self, path: Any, x0: Array) -> bool:
        raise_if_cancelled(self._stop)
        motion = self._steering.paths
        assert motion is not None
        few = motion.sample_states(path, x0, MIN_CHECKS)
        if not all(map(self.has_clearance, few)):
            return False
        # [m] between samples of a path
        count = int(np.ceil(self._length(few) / max(self._margin, 0.02)))
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
