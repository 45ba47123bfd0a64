"""Escapes from local minima: random walks under the full dynamics, over a tree of minima.

Source: Barraquand, Latombe, Robot motion planning: a distributed representation approach,
IJRR 10(6), 1991, section 6 (the randomized path planner).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kinolab.errors import KinolabError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.search.budget import Budget
from kinolab.search.potential.descent import Descent, Ending, PartialMotion
from kinolab.search.potential.field import Field
from kinolab.search.potential.pullback import InputProjection
from kinolab.simulation import Propagator

SHORTEST, LONGEST = 4.0, 60.0  # [s] range of a random walk's duration, log-uniform


@dataclass(eq=False)
class LocalMinimum:
    """A local minimum where a descent ended.

    Attributes:
        trail: The motion to it.
        height: The potential at its end in [m].
        place: The state of the descent at which the potential was lowest, shape (nx,); a descent
            goes on for a while before it counts as stuck.
        lowest: The potential there in [m].
    """

    trail: PartialMotion
    height: float
    place: Array
    lowest: float


class RandomWalkEscapes:
    """Search over local minima, alternating descents and random walks.

    Args:
        descent: Descends it.
        projection: Maps random forces to inputs.
        propagator: Propagates and checks the random walks.
        most: Maximum number of random walks.
        reached: Whether the re-simulation of a motion into the goal ends there too.

    Attributes:
        minima: Minima in order of discovery.
        made: Number of random walks so far.
    """

    def __init__(
        self,
        field: Field,
        descent: Descent,
        projection: InputProjection,
        propagator: Propagator,
        most: int,
        reached: Callable[[PartialMotion], bool],
    ) -> None:
        self._field, self._descent, self._propagator, self._most = field, descent, propagator, most
        self._projection, self._reached = projection, reached
        self.minima: list[LocalMinimum] = []
        self.made = self._since_progress = 0

    def statistics(self, problem: PlanningTask) -> dict[str, float]:
        """Return how many minima and escapes there were, and where the lowest minimum is."""
        counts = {"minima": float(len(self.minima)), "escapes": float(self.made)}
        if not self.minima:
            return counts
        lowest = min(self.minima, key=lambda minimum: minimum.lowest)
        names = problem.model.state_names[: problem.model.nq]
        place = {f"minimum_{n}": float(v) for n, v in zip(names, lowest.place, strict=False)}
        return counts | {"minimum_potential": lowest.lowest, **place}

    def search(
        self, problem: PlanningTask, generator: np.random.Generator, budget: Budget
    ) -> tuple[Ending, PartialMotion]:
        """Return how the search ended, and the motion to the goal or to the nearest approach."""
        trail = PartialMotion([problem.start])
        nearest = trail.until(0)
        while True:
            ending = self._descend(trail, generator, budget)
            nearest = _nearest(problem, trail, nearest)
            if ending is Ending.GOAL:
                return ending, trail
            if ending is Ending.BUDGET or self.made >= self._most:
                return ending, nearest
            trail = self._origin(generator)
            self.made += 1
            if not self._wander(problem, trail, generator, budget):
                return Ending.BUDGET, _nearest(problem, trail, nearest)

    def _descend(
        self, trail: PartialMotion, generator: np.random.Generator, budget: Budget
    ) -> Ending:
        """Descend; a goal that re-simulation misses counts as a minimum."""
        begun = len(trail.states) - 1
        ending = self._descent.follow(trail, generator, budget)
        if ending is Ending.GOAL and not self._reached(trail):
            ending = Ending.MINIMUM
        if ending is Ending.MINIMUM:
            height = float(self._field.potential(trail.end[None])[0])
            # [m] decrease of the lowest minimum that counts as progress
            if all(height < minimum.height - 0.05 for minimum in self.minima):
                self._since_progress = 0
            descended = np.array(trail.states[begun:])
            heights = self._field.potential(descended)
            k = int(np.argmin(heights))
            self.minima.append(LocalMinimum(trail, height, descended[k], float(heights[k])))
        return ending

    def _origin(self, generator: np.random.Generator) -> PartialMotion:
        """Return a motion from whose end to start a random walk.

        It ends at the lowest minimum until that was tried too often, then at a random state on the
        motion to any minimum, so that the search can backtrack as far as it must.
        """
        self._since_progress += 1
        # random walks from the lowest minimum before the search backtracks
        if self._since_progress <= 8:
            trail = min(self.minima, key=lambda minimum: minimum.height).trail
            return trail.until(len(trail.inputs))
        trail = self.minima[int(generator.integers(len(self.minima)))].trail
        return trail.until(int(generator.integers(len(trail.inputs) + 1)))

    def _wander(
        self,
        problem: PlanningTask,
        trail: PartialMotion,
        generator: np.random.Generator,
        budget: Budget,
    ) -> bool:
        """Append a random walk of random duration; False if the budget is spent."""
        h, refused = problem.step, 0
        duration = SHORTEST * (LONGEST / SHORTEST) ** generator.random()
        left = 1 + int(duration / h)
        while left > 0 and refused < 20:  # consecutive rejections after which it ends
            drive = self._drive(problem, generator)
            # [s] for which it keeps one direction, on average
            for _ in range(min(left, 1 + int(generator.exponential(2.0) / h))):
                if budget.spent():
                    return False
                u = drive(trail.end)
                reached, free = self._propagator.step(trail.end.tolist(), u.tolist(), h)
                if not free:
                    refused += 1
                    break
                trail.add(u, np.array(reached))
                left, refused = left - 1, 0
        return True

    def _drive(
        self, problem: PlanningTask, generator: np.random.Generator
    ) -> Callable[[Array], Array]:
        """Sample constant inputs, or a force in one direction on all control points.

        Constant inputs alone make most machines drive in circles.
        """
        lower, upper = problem.model.control_bounds.T
        u: Array = generator.uniform(lower, upper)
        push = generator.normal(size=3)
        if generator.random() < 0.5 or not self._field.pulls:
            return lambda _: u

        def pushed(x: Array) -> Array:
            forces = self._field.pushed(x, push)
            try:
                return self._projection.inputs(x, forces, len(forces))
            except KinolabError:
                return u  # kinematic, or singular here

        return pushed


def _nearest(problem: PlanningTask, trail: PartialMotion, best: PartialMotion) -> PartialMotion:
    """Truncate a motion at its state nearest to the goal; return it if nearer than the best."""
    distances = [problem.goal_distance(x) for x in trail.states]
    k = int(np.argmin(distances))
    return trail.until(k) if distances[k] < problem.goal_distance(best.end) else best
