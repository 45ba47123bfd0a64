"""Is the way of one step free? Coarse looks come first, finer ones where they fail."""

from __future__ import annotations

import math

import numpy as np

from kinolab.bridge.compiled_step import CompiledStep
from kinolab.problem import Problem
from kinolab.world import CollisionChecker

RESOLUTION = 0.01  # [m] that a point may move between two looks, where it is tight
FINEST = 1e-4  # [m] of the same where the start is close to an obstacle
LEVELS = 7  # each looks at twice the distance of the one before
PIECES = 4  # that a way is cut into where a look at the whole of it fails
STATES = 20  # drawn at random to see whether bodies rise and sink


class Sweep:
    """Looks along a step with the machine inflated by how far its points move from where it looks.

    A look at the middle of a way, with a margin of half its length, proves the whole way free.
    Where it fails the way is cut into pieces, down to a resolution that counts as contact.
    """

    def __init__(self, problem: Problem, calls: CompiledStep) -> None:
        self._calls = calls
        self._resolution = _resolution(problem)
        self._tight = problem.checker(margin=self._resolution / 2)
        self._coarse: dict[int, CollisionChecker] = {}
        self._ground = _rises(problem)
        self._workspace = [
            ("xyz".index(axis) * 4 + 3, lower, upper)
            for axis, (lower, upper) in problem.world.bounds.items()
        ]
        self._tight.collides(*problem.placement(problem.start))  # compiles what is compiled late

    def free(self) -> bool:
        """Say whether the state reached is inside the workspace and touches nothing."""
        return self._free_at(self._tight)

    def free_within(self, duration: float, speed: float) -> bool:
        """Say whether the step just made is free, its end first; ``speed`` bounds all points."""
        if not self.free():
            return False
        return self._free_between(0.0, duration, speed)

    def _free_between(self, begin: float, end: float, speed: float) -> bool:
        reach = speed * (end - begin)
        level = max(0, math.ceil(math.log2(max(reach / self._resolution, 1.0))))
        if level < LEVELS:
            self._calls.step((begin + end) / 2)
            if self._free_at(self._checker(level)):
                return True
            if level == 0:
                return False
        pieces = min(PIECES, math.ceil(reach / self._resolution))
        cuts = [begin + (end - begin) * k / pieces for k in range(pieces + 1)]
        return all(
            self._free_between(cuts[k], cuts[k + 1], speed) for k in range(pieces - 1, -1, -1)
        )

    def _checker(self, level: int) -> CollisionChecker:
        if level == 0:
            return self._tight
        if level not in self._coarse:
            margin = self._resolution / 2 * 2**level
            self._coarse[level] = self._tight.inflated(margin, ground=self._ground)
        return self._coarse[level]

    def _free_at(self, checker: CollisionChecker) -> bool:
        calls = self._calls
        calls.frames()
        for row in calls.poses.tolist() if self._workspace else ():
            for entry, lower, upper in self._workspace:
                if not lower <= row[entry] <= upper:
                    return False
        return not checker.collides(calls.poses, calls.ends)


def _resolution(problem: Problem) -> float:
    """Return the spacing of checks: fine enough that the start has room for half of it."""
    room = problem.checker().clearance(*problem.placement(problem.start))
    return float(np.clip(room, FINEST, RESOLUTION))


def _rises(problem: Problem) -> bool:
    """Say whether a body that does not rest on the ground can come nearer to it.

    Margins against the ground would be in the way of one that glides low above it.
    """
    floating = [k for k, body in enumerate(problem.bodies) if not body.touches_ground]
    if not (problem.world.ground and floating):
        return False
    generator = np.random.default_rng(0)
    states = np.array([problem.sample_goal(generator) for _ in range(STATES)])
    states[:, : problem.model.nq] += generator.normal(size=(STATES, problem.model.nq))
    heights = problem.frames(states)[:, floating, 8:]
    return bool(np.ptp(heights, axis=0).max() > FINEST)
