"""Geometric paths in free configuration space, ignoring the dynamics: RRT-Connect.

Source: Kuffner, LaValle, RRT-Connect: an efficient approach to single-query path planning, ICRA
2000; Geraerts, Overmars, Creating high-quality paths for motion planning, IJRR 26(8), 2007 (the
shortcuts); Gammell, Srinivasa, Barfoot, Informed RRT*, IROS 2014 (the informed subset).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from kinolab.concurrency.cancel import CancellationToken, never_cancelled, raise_if_cancelled
from kinolab.numerics.arrays import Array
from kinolab.numerics.manifolds.rotations import unit
from kinolab.numerics.work import charge
from kinolab.problem import PlanningTask
from kinolab.trajopt.nlp.options import GUESS
from kinolab.world.shapes.geometry import core_radius_of, reach_of


def _any_length(paths: Array) -> NDArray[np.bool_]:
    return np.ones(paths.shape[:-2], dtype=bool)


class GeometricPaths:
    """Collision-free geometric paths for one machine in one world.

    Args:
        stop: Cancellation token; cancelling raises a CancelledError.
        clearance: From obstacles, in [m].
    """

    def __init__(
        self,
        problem: PlanningTask,
        generator: np.random.Generator,
        stop: CancellationToken = never_cancelled,
        clearance: float = 0.0,
    ) -> None:
        self._problem, self._generator, self._stop = problem, generator, stop
        self._checker = problem.checker(clearance)
        self._space = problem.space
        self._circles = np.flatnonzero(problem.circular[: problem.model.nq])
        self._weights = problem.weights.copy()
        self._weights[problem.model.nq :] = 0.0  # only the path counts
        shapes = [shape for body in problem.bodies for shape in body.shapes]
        radii = [core_radius_of(shape) for shape in shapes]
        self._apart = GUESS.path_resolution * min(radii, default=1.0)
        self._reach = max(map(reach_of, problem.bodies), default=0.0)

    def find(
        self,
        start: Array,
        end: Array,
        turning: float = 1.0,
        within: Callable[[Array], NDArray[np.bool_]] = _any_length,
        branches: int = 600,
    ) -> Array | None:
        """Return a collision-free path between two states, shape (m, nx); None if none is found.

        All entries but the coordinates are interpolated linearly. At the end angles may differ by
        whole turns from those asked for, and quaternions in sign. The path is checked at samples
        only; a corner may be grazed between two of them.

        Args:
            start: Start state, shape (nx,).
            end: End state, shape (nx,).
            turning: Sampling range of angles and attitudes about those between start and end, as a
                fraction of half a turn.
            within: Whether paths, shape (..., m, nx), are short enough.
            branches: Maximum number of extensions of both trees together.

        Raises:
            CancelledError: If the search is cancelled.
        """
        trees = [_Tree(start), _Tree(end)]
        for k in range(branches):
            raise_if_cancelled(self._stop)
            charge(4e-4)  # [s] of work for a branch, as ``charge`` counts it, its checks apart
            here, there = trees[k % 2], trees[1 - k % 2]
            aim = there.x[0] if k < 2 else self._drawn(start, end, turning, within)
            reached = self._grown(here, aim, there.x[0], within)
            if reached is None:
                continue
            met = self._grown(there, reached, here.x[0], within)
            if met is not None and self._apart_by(met, reached[None])[0] == 0.0:
                paths = [here.path(), there.path()]
                path = np.vstack([paths[k % 2], paths[1 - k % 2][::-1]])
                return self.shorter(self._space.continuous(path))
        return None

    def is_free(self, begin: Array, end: Array) -> bool:
        """Say whether the straight path between two states, shape (nx,), is free at all samples."""
        line = self._line(begin, end)
        return all(self.are_free(line[::apart]) for apart in (GUESS.first_check_stride, 1))

    def samples(self, moved: float, turned: float = 0.0) -> int:
        """Return into how many parts a path is cut, of which no point moves far in any.

        Args:
            moved: Length of the path, in [m].
            turned: By which bodies turn, in [rad].
        """
        count = math.ceil((moved + self._reach * turned) / self._apart)
        return min(max(GUESS.min_path_samples, count), GUESS.max_path_samples)

    def are_free(self, states: Array) -> bool:
        """Say whether all states, shape (m, nx), are collision-free."""
        return self._free(states) == len(states)

    def _drawn(
        self, start: Array, end: Array, turning: float, within: Callable[[Array], NDArray[np.bool_]]
    ) -> Array:
        """Sample a configuration through which a path may be short enough, shape (nx,).

        If none of ``max_draws`` samples is, return the last one.
        """
        for count in (1, GUESS.max_draws - 1):
            x = self.anywhere(start, end, turning, count)
            ends = (np.broadcast_to(at, x.shape) for at in (start, end))
            short = within(np.stack([next(ends), x, next(ends)], axis=1))
            if short.any():
                return np.asarray(x[short.argmax()])
        return np.asarray(x[-1])

    def anywhere(self, start: Array, end: Array, turning: float, count: int) -> Array:
        """Sample configurations with attitudes near those between start and end, (count, nx)."""
        nq, generator = self._problem.model.nq, self._generator
        lower, upper = self._problem.sampling_bounds[:nq].T
        x = start + generator.random((count, 1)) * (self._space.nearest(start, end) - start)
        lines = np.flatnonzero(~self._space.turns[:nq])
        x[:, lines] = generator.uniform(lower[lines], upper[lines], (count, len(lines)))
        turns = generator.uniform(-np.pi, np.pi, (count, len(self._circles)))
        x[:, self._circles] += turning * turns
        for part in self._space.spheres:
            for row in x[:, part.own]:
                row[:] = part.near(unit(row), turning * np.pi, generator)
        return x

    def _grown(
        self, tree: _Tree, aim: Array, end: Array, within: Callable[[Array], NDArray[np.bool_]]
    ) -> Array | None:
        """Extend a tree straight towards a state as far as it is free; return the new leaf.

        None if the first step collides or a path through the leaf to the end would be too long.
        """
        parent = int(self._apart_by(aim, tree.x).argmin())
        line = self._line(tree.x[parent], aim)
        free = self._free(line)
        if free < 2:
            return None
        leaf = aim if free == len(line) else line[free - 1]
        if not within(np.vstack([tree.path(parent), leaf, end])):
            return None
        tree.add(leaf, parent)
        return leaf

    def _apart_by(self, x: Array, others: Array) -> Array:
        """Return weighted distances from one configuration (nx,) to others (m, nx), shape (m,)."""
        return self._space.distance(x, others, self._weights)

    def _line(self, begin: Array, end: Array) -> Array:
        """Sample the straight path so densely that no point moves far between samples, (m, nx)."""
        few = self._between(begin, end, GUESS.min_path_samples)
        poses = self._problem.frames(few).reshape(len(few), -1, 3, 4)
        moved = np.linalg.norm(np.diff(poses[..., 3], axis=0), axis=-1)
        turned = np.linalg.norm(np.diff(poses[..., :3], axis=0), axis=(-2, -1))
        length = float((moved + self._reach * turned).sum(axis=0).max(initial=0.0))
        return self._between(begin, end, self.samples(length))

    def _between(self, begin: Array, end: Array, count: int) -> Array:
        """Return evenly spaced states on the shortest straight path, shape (count + 1, nx)."""
        return self._space.interpolate(begin, end, np.linspace(0.0, 1.0, count + 1))

    def _free(self, line: Array) -> int:
        """Count the states, shape (m, nx), before the first collision."""
        problem = self._problem
        frames = problem.model.frames(line)
        ends = problem.model.cables(line) if problem.cables else None
        first = self._checker.first_collision(frames, ends)
        outside = np.asarray((problem.pose_margins(frames) < 0).any(axis=1))
        if first is not None:
            outside[first] = True
        free = int(outside.argmax()) if outside.any() else len(line)
        charge(6e-5 + 3e-6 * len(line))
        return free

    def shorter(self, path: Array) -> Array:
        """Shorten a path, shape (m, nx), by random shortcuts."""
        for _ in range(GUESS.max_path_shortcuts):
            raise_if_cancelled(self._stop)
            lengths = self._space.distance(path[:-1], path[1:], self._weights)
            along = np.concatenate([[0.0], np.cumsum(lengths)])
            a, b = np.sort(self._generator.uniform(0.0, along[-1], 2))
            i, j = int(np.searchsorted(along, a)), int(np.searchsorted(along, b))
            if not 0 < i < j < len(path):
                continue
            begin, end = _at(path, along, a), _at(path, along, b)
            line = self._line(begin, end)
            if self._free(line) == len(line):
                path = self._space.continuous(np.vstack([path[:i], begin, end, path[j:]]))
        return path


class _Tree:
    """A tree of configurations; the last leaf is the one added last."""

    def __init__(self, root: Array) -> None:
        self.x, self._parents = root[None].copy(), [-1]

    def add(self, x: Array, parent: int) -> None:
        self.x = np.vstack([self.x, x])
        self._parents.append(parent)

    def path(self, leaf: int = -1) -> Array:
        """Return the states from the root to a leaf, by default the last one; shape (m, nx)."""
        nodes = [leaf % len(self.x)]
        while self._parents[nodes[-1]] >= 0:
            nodes.append(self._parents[nodes[-1]])
        path: Array = self.x[nodes[::-1]]
        return path


def _at(path: Array, along: Array, length: float) -> Array:
    """Interpolate a path at an arc length, shape (nx,)."""
    return np.array([np.interp(length, along, column) for column in path.T])
