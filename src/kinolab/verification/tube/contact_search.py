"""Whether anything can be touched in a tube: the nominal clearance against how far points are off.

The clearance of the nominal motion changes between two samples by no more than points move. An
interval of time is halved until it has more clearance than points are off in its step, or a sample
has less.

Source: Piyavskii, An algorithm for finding the absolute extremum of a function, USSR Computational
Mathematics and Mathematical Physics 12(4), 1972.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.verification.between_samples.dense_motion import DenseMotion
from kinolab.verification.tube.hazards import Hazard
from kinolab.world import CollisionChecker, World

# [m]: what an integrator of 1e-9 and clearances of 1e-8 may be off by, and more
SLACK = 1e-6
Placement: TypeAlias = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True, eq=False)
class ContactSearch:
    """The nominal motion among obstacles.

    Attributes:
        problem: Machine and world, without a distance that plans keep.
        dense: The nominal motion.
    """

    problem: PlanningTask
    dense: DenseMotion

    @cached_property
    def checkers(self) -> list[CollisionChecker]:
        """One for each body alone, one for cables, and one for bodies among each other."""
        problem = self.problem
        none = [replace(body, shapes=()) for body in problem.bodies]
        apart = World(ground=False)
        alone = [[*none[:k], body, *none[k + 1 :]] for k, body in enumerate(problem.bodies)]
        pairs = problem.machine.collisions
        made = [
            *(CollisionChecker(bodies, problem.world) for bodies in alone),
            CollisionChecker(none, problem.world, cables=problem.cables),
            CollisionChecker(problem.bodies, apart, cables=problem.cables, self_pairs=pairs),
        ]
        ground = problem.world.ground
        return [one.inflated(0.0, ground=ground and one is not made[-1]) for one in made]

    def clearances(self, x: Array) -> Array:
        """Return the clearance of each of ``checkers`` at states (m, nx), shape (checkers, m)."""
        poses, ends = self.problem.placement(x)
        none = ends[:, :0] if len(ends) else ends
        each = [none] * len(self.problem.bodies) + [ends, ends]
        return np.array(
            [one.clearances(poses, e) for one, e in zip(self.checkers, each, strict=True)]
        )

    @classmethod
    def of(cls, dense: DenseMotion) -> ContactSearch:
        """Return a search along a motion; a plan's distance from obstacles is left to a run."""
        world = replace(dense.problem.world, clearance=0.0)
        return cls(replace(dense.problem, world=world), dense)

    def first(self, off: Array) -> tuple[Hazard | None, float]:
        """Return what could be touched first, and what clearance is left at least where nothing is.

        Args:
            off: How far points of each body, and of cables, are from their nominal places at most
                in each step, (bodies + 1, steps).

        Returns:
            A hazard or None, and the clearance in [m] at samples less that, at least.
        """
        most = off.max(axis=0)
        found = self._first(self.problem.checker(), most, self.problem.placement)
        if found[0] is None:
            return found
        poses, cabled = self._bodies_alone, self.problem.placement
        each = [(row, poses) for row in off[:-1]] + [(off[-1], cabled), (most, cabled)]
        parts = [
            self._first(checker, row, placement)
            for checker, (row, placement) in zip(self.checkers, each, strict=True)
        ]
        touched = [hazard for hazard, _ in parts if hazard is not None]
        least = min(spare for _, spare in parts)
        return min(touched, key=lambda hazard: hazard.time, default=None), least

    def _bodies_alone(self, x: Array) -> tuple[Array, Array]:
        poses, ends = self.problem.placement(x)
        return poses, ends[:, :0] if len(ends) else ends

    def _first(
        self, checker: CollisionChecker, off: Array, placement: Placement
    ) -> tuple[Hazard | None, float]:
        """Return what could be touched first by what a checker looks at, as ``first``."""
        steps = self.dense.steps
        some = np.flatnonzero(steps.knots < len(off))
        knots, begin, end = steps.knots[some], steps.begin[some], steps.end[some]
        speed, least, contact = steps.speed[some], np.inf, np.inf
        for _ in range(40):  # halvings of a step, into parts of 1e-12
            if not len(begin):
                break
            middle = 0.5 * (begin + end)
            states = self.dense.motion.along(knots, middle)
            gaps = checker.clearances(*placement(states))
            spare = gaps - off[knots] - SLACK
            least = min(least, float(spare.min()))
            if (spare <= 0.0).any():
                contact = min(contact, float(middle[spare <= 0.0].min()))
            more = (spare > 0.0) & (spare <= speed * 0.5 * (end - begin)) & (begin < contact)
            halves = (begin[more], middle[more]), (middle[more], end[more])
            begin, end = (np.concatenate(side) for side in zip(*halves, strict=True))
            knots, speed = np.tile(knots[more], 2), np.tile(speed[more], 2)
        if len(begin):
            contact = min(contact, float(begin.min()))
        if not np.isfinite(contact):
            return None, least
        return Hazard(contact, self._described(checker, contact, off)), least

    def _described(self, checker: CollisionChecker, time: float, off: Array) -> str:
        """Say what could touch what at a time in [s]."""
        k = int(np.clip(np.searchsorted(self.dense.motion.t, time, "right") - 1, 0, len(off) - 1))
        x = self.dense.motion.between(k, np.array([time]))
        reach = off[k] + 2 * SLACK
        if not np.isfinite(reach):
            return "bodies could be anywhere"
        near = checker.inflated(reach, ground=bool(checker.scene.ground))
        found = near.contacts(*(a[0] for a in self._placed(x, checker)))
        told = f"{found[0].body} could touch {found[0].obstacle}" if found else "something is near"
        return f"{told}: {1000 * off[k]:.3g} mm off"

    def _placed(self, x: Array, checker: CollisionChecker) -> tuple[Array, Array]:
        poses, ends = self.problem.placement(x)
        return poses, ends if len(checker.cables) else np.zeros((1, 0, 2, 3))
