"""Continuous collision check of one step by recursive subdivision with inflated bodies."""

from __future__ import annotations

import math

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.simulation.compiled_step import CompiledStep
from kinolab.world import CollisionChecker
from kinolab.world.placed_shapes import lowest_heights

RESOLUTION = 0.01  # [m] that a point may move between two checks, at the finest level
MIN_RESOLUTION = 1e-4  # [m], where the start is close to an obstacle
RANDOM_STATES = 20  # at which bodies' heights are compared
SAFETY_FACTOR = 1.1  # on speeds at both ends of a step, for those in between
MAX_DOUBLINGS = 7  # levels, each checking segments twice as long as the one before
SUBDIVISIONS = 4  # of a segment whose check fails
MOST_CHECKS = 1_000_000  # at the finest level; a step of more, such as one of years, is refused


class ContinuousCollisionCheck:
    """Checks a step with the machine inflated by how far its points move from the sample.

    A check at a segment's midpoint, with a margin of half its length, proves the segment free.
    Where it fails the segment is subdivided, down to a resolution that counts as contact.

    Args:
        problem: Provides machine and world.
        calls: The step to check.
        margin: Additional clearance in [m].
        finest: Resolution in [m], where that of the problem is coarser: passages half as wide
            count as free.
    """

    def __init__(
        self,
        problem: PlanningTask,
        calls: CompiledStep,
        margin: float = 0.0,
        finest: float = math.inf,
    ) -> None:
        self._calls = calls
        self._resolution = min(resolution(problem), max(finest, MIN_RESOLUTION))
        self._tight = problem.checker(margin=margin + self._resolution / 2)
        self._coarse: dict[int, CollisionChecker] = {}
        self._ground = moves_upright(problem, touching=False)
        # A foot may touch the ground but not sink: only fine checks tell the difference.
        self._levels = 1 if moves_upright(problem, touching=True) else MAX_DOUBLINGS
        self._moving = problem.moving
        self._workspace = [
            ("xyz".index(axis) * 4 + 3, lower, upper)
            for axis, (lower, upper) in problem.world.bounds.items()
        ]
        self._tight.build()
        self._tight.contacts(*problem.placement(problem.start))  # warms up lazy compilation

    def free(self) -> bool:
        """Return whether the state reached is in the workspace and collision-free."""
        return self._free_at(self._tight, 0.0)

    def free_within(self, duration: float, speed: float) -> bool:
        """Check the step just made, its end first; ``speed`` bounds all points, in [m/s]."""
        if not speed * duration <= MOST_CHECKS * self._resolution or not self.free():
            return False
        return self._free_between(0.0, duration, speed)

    def rejection_sources(self) -> list[str]:
        """Name the contacts and limits that failed the last check."""
        calls = self._calls
        outside = [
            f"{'xyz'[entry // 4]} of {body.name} leaves the workspace"
            for body, row in zip(self._tight.bodies, calls.poses, strict=True)
            for entry, lower, upper in self._workspace
            if body.moves and not lower <= row[entry] <= upper
        ]
        touching = self._tight.contacts(calls.poses, calls.ends)
        return outside + [f"{contact.body} – {contact.obstacle}" for contact in touching]

    def _free_between(self, begin: float, end: float, speed: float) -> bool:
        reach = speed * (end - begin)
        level = max(0, math.ceil(math.log2(max(reach / self._resolution, 1.0))))
        if level < self._levels:
            self._calls.step((begin + end) / 2)
            checker = self._checker(level)
            if self._free_at(checker, checker.margin if level else 0.0):
                return True
            if level == 0:
                return False
        pieces = min(SUBDIVISIONS, math.ceil(reach / self._resolution))
        cuts = [begin + (end - begin) * k / pieces for k in range(pieces + 1)]
        return all(
            self._free_between(cuts[k], cuts[k + 1], speed) for k in range(pieces - 1, -1, -1)
        )

    def _checker(self, level: int) -> CollisionChecker:
        if level == 0:
            return self._tight
        if level not in self._coarse:
            margin = self._tight.margin - self._resolution / 2 + self._resolution / 2 * 2**level
            self._coarse[level] = self._tight.inflated(margin, ground=self._ground)
        return self._coarse[level]

    def _free_at(self, checker: CollisionChecker, margin: float) -> bool:
        """Check obstacles, and the workspace with a margin in [m], at the state reached."""
        calls = self._calls
        calls.frames()
        for row in calls.poses[self._moving].tolist() if self._workspace else ():
            for entry, lower, upper in self._workspace:
                if not lower + margin <= row[entry] <= upper - margin:
                    return False
        return not checker.collides(calls.poses, calls.ends)


def resolution(problem: PlanningTask) -> float:
    """Return the spacing of checks in [m]: the clearance of the start, clipped."""
    clearance = problem.checker().clearance(*problem.placement(problem.start), RESOLUTION)
    return max(clearance, MIN_RESOLUTION)


def moves_upright(problem: PlanningTask, *, touching: bool) -> bool:
    """Return whether any body's lowest point changes height, of those touching the ground or not.

    Bodies that stay at one height need no margin against the ground, which would block them.
    """
    chosen = [k for k, body in enumerate(problem.bodies) if body.touches_ground is touching]
    if not (problem.world.ground and chosen):
        return False
    generator, nq = np.random.default_rng(0), problem.model.nq
    states = problem.sample_goals(generator, np.ones(RANDOM_STATES))
    states[:, :nq] += generator.normal(size=(RANDOM_STATES, nq))
    poses = problem.frames(states).reshape(RANDOM_STATES, -1, 3, 4)
    lowest = [
        lowest_heights(shape, poses[:, body])
        for body in chosen
        for shape in problem.bodies[body].shapes
    ]
    # Not finite: some sampled states have no pose, which says nothing about heights.
    return bool(lowest) and not np.ptp(lowest, axis=1).max() <= MIN_RESOLUTION
