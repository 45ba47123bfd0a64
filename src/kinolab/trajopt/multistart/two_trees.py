"""Guesses by two trees, from the start and backward from the goal, with a gap where they meet.

What a driftless machine does it also does backward, at opposite speeds: a tree from the goal holds
motions that end there exactly. Motions that are stable one way, such as trailers that are
pulled, lead both from the start and, run backward, into the goal, where a single tree would have to
push them in. Direct shooting closes the gap that is left.

Source: LaValle, Kuffner, Randomized kinodynamic planning, IJRR 20(5), 2001, section 5 (two trees,
and the gap between them); Lamiraux, Ferre, Vallee, Kinodynamic motion planning: connecting
exploration trees using trajectory optimization methods, ICRA 2004.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import product

import numpy as np
import scipy

from kinolab.numerics.arrays import Array
from kinolab.numerics.work import charge
from kinolab.problem import PlanningTask
from kinolab.search.tree import growth_seconds, search_state, step_seconds
from kinolab.search.tree.sampled.sampled_growth import Growth
from kinolab.search.tree.sampled.sampled_tree import SampledTree
from kinolab.search.tree.tree import controls_to
from kinolab.simulation.rollout import Rollout
from kinolab.trajopt.exact.segments import segment_problem
from kinolab.trajopt.multistart.driftless import is_driftless
from kinolab.trajopt.nlp.decision import Knots, resampled
from kinolab.trajopt.nlp.options import GUESS


def reversal(problem: PlanningTask) -> Array | None:
    """Return the signs s of inputs under which motions run backward, f(x, s u) = -f(x, u).

    A speed changes its sign, a curvature does not. Attitudes are left out: the two trees are
    compared entry by entry.

    Returns:
        Shape (nu,), each 1 or -1; None where motions do not run backward within the limits.
    """
    if not is_driftless(problem) or problem.space.spheres:
        return None
    model, generator = problem.model, np.random.default_rng(0)
    lower, upper = model.control_bounds.T
    x = np.stack([problem.sample(generator) for _ in range(GUESS.reversed_samples)])
    u = generator.uniform(lower, upper, (len(x), model.nu))
    back = -model.f(x, u)
    for signs in map(np.array, product((1.0, -1.0), repeat=model.nu)):
        symmetric = np.array_equal(lower[signs < 0], -upper[signs < 0])
        if symmetric and np.allclose(model.f(x, signs * u), back):
            return signs
    return None


def luby(k: int) -> int:
    """Return the k-th of 1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8, ... (k = 1, 2, ...).

    Restarts of such lengths take at most a logarithm more than the best lengths, were they known.

    Source: Luby, Sinclair, Zuckerman, Optimal speedup of Las Vegas algorithms, Information
    Processing Letters 47, 1993.
    """
    while k & (k + 1):  # not the last one of a doubled sequence
        k -= (1 << (k.bit_length() - 1)) - 1
    return (k + 1) // 2


class TwoTrees:
    """Guesses that lead from the start into the goal but for one gap.

    Args:
        signs: Of its inputs, by ``reversal``.
        cancelled: Whether to give up.
    """

    def __init__(
        self,
        problem: PlanningTask,
        signs: Array,
        generator: np.random.Generator,
        cancelled: Callable[[], bool],
    ) -> None:
        self._problem, self._signs = problem, signs
        self._generator, self._cancelled = generator, cancelled
        self._grown_pairs = 0

    def prepare(self, end: Array) -> None:
        """Compile and load what trees from the start and from an end, shape (nx,), need."""
        for task in (self._problem, segment_problem(self._problem, end, self._problem.start)):
            self._grown(task, 0)

    def guesses(self, end: Array, knots: int) -> Iterator[tuple[Knots, int]]:
        """Grow two new trees; yield guesses and their steps of the problem per knot interval.

        Pairs of nodes come by their gap times the duration, both of which shooting has to mend;
        none begins at the children of one node again. How large trees are follows ``luby``.

        Args:
            end: A state in the goal, shape (nx,), free of collisions.
            knots: About how many knots a guess has.
        """
        self._grown_pairs += 1
        problem, iterations = self._problem, GUESS.tree_iterations * luby(self._grown_pairs)
        back = segment_problem(problem, end, problem.start)
        trees = [self._grown(task, iterations) for task in (problem, back)]
        if self._cancelled():
            return
        met = set()
        for here, there in self._pairs(*trees):
            parent = int(trees[0].nodes.parent[here])
            if parent not in met:
                met.add(parent)
                motion = self._joined(trees, here, there, back)
                if motion is not None:
                    yield self._in_knots(*motion, knots)
            if len(met) >= GUESS.pairs or self._cancelled():
                return

    def _grown(self, task: PlanningTask, iterations: int) -> SampledTree:
        seed = int(self._generator.integers(2**31)) if iterations else 0
        search = search_state(task, GUESS.tree_goal_scale, seed)
        growth = Growth(GUESS.tree_goal_bias, 1, *GUESS.tree_steps)
        tree = SampledTree(search, growth, iterations + 2)
        tree.begin()
        tree.grow(0)
        each, done = step_seconds(task), 0
        while done < iterations and not self._cancelled():
            before = tree.steps_made
            ended, made = tree.grow(min(GUESS.tree_slice, iterations - done))
            charge(growth_seconds(each, tree.steps_made - before, made))
            done += made
            if ended:
                break
        return tree

    def _pairs(self, here: SampledTree, there: SampledTree) -> Iterator[tuple[int, int]]:
        """Yield nodes of both trees that are near each other, the best pair first."""
        problem = self._problem
        counted = np.flatnonzero(problem.weights > 0)
        weights, circular = problem.weights[counted], problem.circular[counted]
        periods = np.where(circular, 2 * np.pi * weights, 0.0)
        points = []
        for tree in (here, there):
            at = tree.nodes.x[: int(tree.nodes.size[0]), counted] * weights
            points.append(np.where(circular, np.mod(at, np.where(circular, periods, 1.0)), at))
        index = scipy.spatial.cKDTree(points[1], boxsize=periods)
        charge(1e-5 * len(points[0]))  # [s] of work to find a node's nearest one in the other tree
        # Where all nodes are about as near, the nearest one would be looked for among all of them.
        gaps, nearest = index.query(points[0], eps=GUESS.pair_slack)
        steps = here.nodes.cost[: len(gaps)] + there.nodes.cost[nearest]
        for k in np.argsort(gaps * steps, kind="stable").tolist():
            if steps[k]:
                yield k, int(nearest[k])

    def _joined(
        self, trees: list[SampledTree], here: int, there: int, back: PlanningTask
    ) -> tuple[Array, Array] | None:
        """Return states (N+1, nx) and inputs (N, nu) by way of two nodes, with a gap."""
        u, v = (controls_to(tree.nodes, k) for tree, k in zip(trees, (here, there), strict=True))
        x = Rollout(self._problem).follow(self._problem.start, u)
        y = Rollout(back).follow(back.start, v)
        if x is None or y is None:
            return None
        states = np.vstack([x[:-1], y[::-1]])
        return self._problem.space.continuous(states), np.vstack([u, self._signs * v[::-1]])

    def _in_knots(self, x: Array, u: Array, knots: int) -> tuple[Knots, int]:
        step, block = self._problem.step, max(1, round(len(u) / knots))
        count = math.ceil(len(u) / block)
        even = resampled(step * np.arange(len(u) + 1.0), x, u, count, self._problem.space)
        return Knots(even.x, even.u, block * step), block
