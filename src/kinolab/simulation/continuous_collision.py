"""Is the way of one step free? Coarse looks come first, finer ones where they fail."""

from __future__ import annotations

import math

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.simulation.compiled_step import CompiledStep
from kinolab.world import CollisionChecker, lowest_z

RESOLUTION = 0.01  # [m] that a point may move between two looks, where it is tight
MIN_RESOLUTION = 1e-4  # [m] of the same where the start is close to an obstacle
RANDOM_STATES = 20  # drawn at random to see whether bodies rise and sink
SAFETY_FACTOR = 1.1  # factor on what is measured at both ends of a step, for what lies in between
MAX_DOUBLINGS = 7  # each looks at twice the distance of the one before
SUBDIVISIONS = 4  # that a way is cut into where a look at the whole of it fails


class ContinuousCollisionCheck:
    """Looks along a step with the machine inflated by how far its points move from where it looks.

    A look at the middle of a way, with a margin of half its length, proves the whole way free.
    Where it fails the way is cut into pieces, down to a resolution that counts as contact.

    Args:
        problem: Whose machine and world.
        calls: The step that is looked at.
        margin: Room in [m] that is asked for in addition.
    """

    def __init__(self, problem: PlanningTask, calls: CompiledStep, margin: float = 0.0) -> None:
        self._calls = calls
        self._resolution = resolution(problem)
        self._tight = problem.checker(margin=margin + self._resolution / 2)
        self._coarse: dict[int, CollisionChecker] = {}
        self._ground = moves_upright(problem, touching=False)
        # A foot may come down to the ground and no further: only fine looks tell the difference.
        self._levels = 1 if moves_upright(problem, touching=True) else MAX_DOUBLINGS
        self._workspace = [
            ("xyz".index(axis) * 4 + 3, lower, upper)
            for axis, (lower, upper) in problem.world.bounds.items()
        ]
        self._tight.build()
        self._tight.contacts(*problem.placement(problem.start))  # compiles what is compiled late

    def free(self) -> bool:
        """Say whether the state reached is inside the workspace and touches nothing."""
        return self._free_at(self._tight, 0.0)

    def free_within(self, duration: float, speed: float) -> bool:
        """Say whether the step just made is free, its end first; ``speed`` bounds all points."""
        if not self.free():
            return False
        return self._free_between(0.0, duration, speed)

    def rejection_sources(self) -> list[str]:
        """Name what is in the way at the last look, which failed."""
        calls = self._calls
        outside = [
            f"{'xyz'[entry // 4]} of {body.name} leaves the workspace"
            for body, row in zip(self._tight.bodies, calls.poses, strict=True)
            for entry, lower, upper in self._workspace
            if not lower <= row[entry] <= upper
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
        for row in calls.poses.tolist() if self._workspace else ():
            for entry, lower, upper in self._workspace:
                if not lower + margin <= row[entry] <= upper - margin:
                    return False
        return not checker.collides(calls.poses, calls.ends)


def resolution(problem: PlanningTask) -> float:
    """Return the spacing of checks: fine enough that the start has room for half of it."""
    clearance = problem.checker().clearance(*problem.placement(problem.start))
    return float(np.clip(clearance, MIN_RESOLUTION, RESOLUTION))


def moves_upright(problem: PlanningTask, *, touching: bool) -> bool:
    """Say whether a body's lowest point rises and sinks, of those that may touch the ground or not.

    Margins against the ground would be in the way of what glides at one height.
    """
    chosen = [k for k, body in enumerate(problem.bodies) if body.touches_ground is touching]
    if not (problem.world.ground and chosen):
        return False
    generator, nq = np.random.default_rng(0), problem.model.nq
    states = np.array([problem.sample_goal(generator) for _ in range(RANDOM_STATES)])
    states[:, :nq] += generator.normal(size=(RANDOM_STATES, nq))
    poses = problem.frames(states)[:, chosen].reshape(RANDOM_STATES, len(chosen), 3, 4)
    lowest = [
        [lowest_z(shape, pose[k]) for pose in poses]
        for k, body in enumerate(chosen)
        for shape in problem.bodies[body].shapes
    ]
    # Not finite: the machine has no pose at some of the states, which says nothing about heights.
    return bool(lowest) and not np.ptp(lowest, axis=1).max() <= MIN_RESOLUTION
