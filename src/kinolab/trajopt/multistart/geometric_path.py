"""Ways through the free configurations, whatever the machine can follow of them: RRT-Connect.

Source: Kuffner, LaValle, RRT-Connect: an efficient approach to single-query path planning, ICRA
2000; Geraerts, Overmars, Creating high-quality paths for motion planning, IJRR 26(8), 2007 (the
shortcuts); Gammell, Srinivasa, Barfoot, Informed RRT*, IROS 2014 (what is not worth a look).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from kinolab.cancel import CancellationToken, never_cancelled, raise_if_cancelled
from kinolab.numerics.arrays import Array
from kinolab.numerics.quaternions import turned_at_random, unit
from kinolab.problem import PlanningTask
from kinolab.trajopt.options import GUESS
from kinolab.world.geometry import placement, sizes


class GeometricPaths:
    """Ways for one machine in one world.

    Args:
        problem: Whose they are.
        generator: Of the random numbers.
        stop: Says that looking must end, by a CancelledError.
    """

    def __init__(
        self,
        problem: PlanningTask,
        generator: np.random.Generator,
        stop: CancellationToken = never_cancelled,
    ) -> None:
        self._problem, self._generator, self._stop = problem, generator, stop
        self._checker = problem.checker()
        self._space = problem.space
        self._circles = np.flatnonzero(problem.circular[: problem.model.nq])
        self._weights = problem.weights.copy()
        self._weights[problem.model.nq :] = 0.0  # only the way counts
        shapes = [shape for body in problem.bodies for shape in body.shapes]
        radii = [float(np.linalg.norm(sizes(shape)[1])) for shape in shapes]
        self._apart = GUESS.path_resolution * min(radii, default=1.0)
        self._reach = max(
            (
                np.linalg.norm(placement(shape)[:, 3]) + radius
                for shape, radius in zip(shapes, radii, strict=True)
            ),
            default=0.0,
        )

    def find(
        self,
        start: Array,
        end: Array,
        turning: float = 1.0,
        within: Callable[[Array], bool] = lambda _: True,
        branches: int = 600,
    ) -> Array | None:
        """Return a free way between two states, shape (m, nx); None where none was found.

        All but the coordinates changes evenly along it. Angles may come out by whole turns from the
        end that was asked for, and quaternions with the other sign. It is free wherever it is
        looked at; a corner may be grazed between two looks.

        Args:
            start: Where to begin, shape (nx,).
            end: Where to end, shape (nx,).
            turning: How far angles and attitudes are drawn from those between start and end, as a
                share of half a turn.
            within: Whether a way, shape (m, nx), is short enough.
            branches: How often a tree is grown, both together, before it is given up.

        Raises:
            CancelledError: If looking for it took too long.
        """
        trees = [_Tree(start), _Tree(end)]
        for k in range(branches):
            raise_if_cancelled(self._stop)
            here, there = trees[k % 2], trees[1 - k % 2]
            aim = there.x[0] if k < 2 else self._drawn(start, end, turning, within)
            reached = self._grown(here, aim, there.x[0], within)
            if reached is None:
                continue
            met = self._grown(there, reached, here.x[0], within)
            if met is not None and self._apart_by(met, reached[None])[0] == 0.0:
                paths = [here.path(), there.path()]
                path = np.vstack([paths[k % 2], paths[1 - k % 2][::-1]])
                return self._shorter(self._space.continuous(path))
        return None

    def is_free(self, begin: Array, end: Array) -> bool:
        """Say whether the straight way between two states is free wherever it is looked at."""
        line = self._line(begin, end)
        return all(self.are_free(line[::apart]) for apart in (GUESS.first_check_stride, 1))

    def are_free(self, states: Array) -> bool:
        """Say whether a machine touches nothing in any of some states, shape (m, nx)."""
        return self._free(states) == len(states)

    def _drawn(
        self, start: Array, end: Array, turning: float, within: Callable[[Array], bool]
    ) -> Array:
        """Return a configuration at random through which a way may be short enough.

        It is the last one drawn where none of DRAWS is.
        """
        for _ in range(GUESS.max_draws):
            x = self._anywhere(start, end, turning)
            if within(np.stack([start, x, end])):
                break
        return x

    def _anywhere(self, start: Array, end: Array, turning: float) -> Array:
        """Return a configuration at random, turned like one between start and end or nearly so."""
        nq, generator = self._problem.model.nq, self._generator
        lower, upper = self._problem.sampling_bounds[:nq].T
        x = start + generator.random() * (self._space.nearest(start, end) - start)
        lines = np.flatnonzero(~self._space.turns[:nq])
        x[lines] = generator.uniform(lower[lines], upper[lines])
        x[self._circles] += turning * generator.uniform(-np.pi, np.pi, len(self._circles))
        for own in self._space.quaternions:
            x[own] = turned_at_random(unit(x[own]), turning * np.pi, generator)
        return x

    def _grown(
        self, tree: _Tree, aim: Array, end: Array, within: Callable[[Array], bool]
    ) -> Array | None:
        """Grow a tree straight towards a state as far as it is free; return its new leaf.

        None where it is not free, or where a way through there to the end would be too long.
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
        """Return weighted distances of configurations (m, nx) from one (nx,), shape (m,)."""
        return self._space.distance(x, others, self._weights)

    def _line(self, begin: Array, end: Array) -> Array:
        """Return states on the shortest straight way, so many that no point moves far between."""
        few = self._between(begin, end, GUESS.min_path_samples)
        poses = self._problem.frames(few).reshape(len(few), -1, 3, 4)
        moved = np.linalg.norm(np.diff(poses[..., 3], axis=0), axis=-1)
        turned = np.linalg.norm(np.diff(poses[..., :3], axis=0), axis=(-2, -1))
        length = float((moved + self._reach * turned).sum(axis=0).max(initial=0.0))
        return self._between(
            begin,
            end,
            min(
                max(GUESS.min_path_samples, math.ceil(length / self._apart)), GUESS.max_path_samples
            ),
        )

    def _between(self, begin: Array, end: Array, count: int) -> Array:
        """Return states at even shares of the shortest straight way, shape (count + 1, nx)."""
        return self._space.interpolate(begin, end, np.linspace(0.0, 1.0, count + 1))

    def _free(self, line: Array) -> int:
        """Return how many of some states are free before one is not."""
        problem = self._problem
        frames = problem.model.frames(line)
        ends = problem.model.cables(line) if problem.cables else None
        first = self._checker.first_collision(frames, ends)
        outside = np.asarray((problem.pose_margins(frames) < 0).any(axis=1))
        if first is not None:
            outside[first] = True
        return int(outside.argmax()) if outside.any() else len(line)

    def _shorter(self, path: Array) -> Array:
        """Return a way with some of its corners cut off."""
        for _ in range(GUESS.max_path_shortcuts):
            raise_if_cancelled(self._stop)
            lengths = [self._apart_by(a, b[None])[0] for a, b in pairwise(path)]
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
    """A tree of configurations; its last leaf is what it was grown to last."""

    def __init__(self, root: Array) -> None:
        self.x, self._parents = root[None].copy(), [-1]

    def add(self, x: Array, parent: int) -> None:
        self.x = np.vstack([self.x, x])
        self._parents.append(parent)

    def path(self, leaf: int = -1) -> Array:
        """Return the states from the root to a leaf, the last one if none is named."""
        nodes = [leaf % len(self.x)]
        while self._parents[nodes[-1]] >= 0:
            nodes.append(self._parents[nodes[-1]])
        path: Array = self.x[nodes[::-1]]
        return path


def _at(path: Array, along: Array, length: float) -> Array:
    """Return the state after some length of a way, shape (nx,)."""
    return np.array([np.interp(length, along, column) for column in path.T])
