"""Whether anything can be touched in a tube: the nominal clearance against how far points are off.

The clearance of the nominal motion changes between two samples by no more than points move. An
interval of time is halved until it has more clearance than points are off in its step, or a sample
has less.

Source: Piyavskii, An algorithm for finding the absolute extremum of a function, USSR Computational
Mathematics and Mathematical Physics 12(4), 1972.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.verification.dense_motion import DenseMotion
from kinolab.verification.tube.hazards import Hazard

# [m]: what an integrator of 1e-9 and clearances of 1e-8 may be off by, and more
SLACK = 1e-6
MOST_HALVINGS = 40  # of a step: into parts of 1e-12


@dataclass(frozen=True, eq=False)
class ContactSearch:
    """The nominal motion among obstacles.

    Attributes:
        problem: Machine and world, without a distance that plans keep.
        dense: The nominal motion.
    """

    problem: PlanningTask
    dense: DenseMotion

    @classmethod
    def of(cls, dense: DenseMotion) -> ContactSearch:
        """Return a search along a motion; a plan's distance from obstacles is left to a run."""
        world = replace(dense.problem.world, clearance=0.0)
        return cls(replace(dense.problem, world=world), dense)

    def first(self, off: Array) -> tuple[Hazard | None, float]:
        """Return what could be touched first, and what clearance is left at least where nothing is.

        Args:
            off: How far points are from their nominal places at most in each step, (steps,).

        Returns:
            A hazard or None, and the clearance in [m] at samples less that, at least.
        """
        checker, steps = self.problem.checker(), self.dense.steps
        some = np.flatnonzero(steps.knots < len(off))
        knots, begin, end = steps.knots[some], steps.begin[some], steps.end[some]
        speed, least, contact = steps.speed[some], np.inf, np.inf
        for _ in range(MOST_HALVINGS):
            if not len(begin):
                break
            middle = 0.5 * (begin + end)
            states = self.dense.motion.along(knots, middle)
            gaps = checker.clearances(*self.problem.placement(states))
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
        return Hazard(contact, self._described(contact, off)), least

    def _described(self, time: float, off: Array) -> str:
        """Say what could touch what at a time in [s]."""
        k = int(np.clip(np.searchsorted(self.dense.motion.t, time, "right") - 1, 0, len(off) - 1))
        x = self.dense.motion.between(k, np.array([time]))
        reach = off[k] + 2 * SLACK
        if not np.isfinite(reach):
            return "bodies could be anywhere"
        found = self.problem.checker(reach).contacts(*(a[0] for a in self._placed(x)))
        told = f"{found[0].body} could touch {found[0].obstacle}" if found else "something is near"
        return f"{told}: {1000 * off[k]:.3g} mm off"

    def _placed(self, x: Array) -> tuple[Array, Array]:
        poses, ends = self.problem.placement(x)
        return poses, ends if len(ends) else np.zeros((1, 0, 2, 3))
