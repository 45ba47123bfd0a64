"""Faults in what a plan is said to solve: a goal that it misses, obstacles that it hits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from kinolab.problem import PlanningTask
from kinolab.world import World
from kinolab.world.obstacles.obstacle import Obstacle, box_obstacle

from .faults import NEAR, Array, Case, Fault, Generator, Kind
from .judge import Verdict
from .solids import Solid, Still, nearest_pair

MISSED = 1.01  # tolerances by which goals are missed
INTO = 1e-3  # [m] by which an obstacle is moved into the way, beyond the clearance
SHEET = 1e-3  # [m] thickness of a wall
WIDTHS = (0.01, 0.3)  # [m] of a wall, from edge to edge
SHALLOWEST = 1e-4  # [m] how deep the middle of a wall lies in a body at least
SURE = 2e-5  # [m] of overlap, twice what a contact must have, from which on it is certain
LOOKS = 12  # times at which nearest pairs are looked for


def like(problem: PlanningTask, **changes: Any) -> PlanningTask:
    """Return a problem with some fields changed; obstacles that stay are not prepared again."""
    made = replace(problem, **changes)
    if "world" not in changes:
        for name in ("_checker", "_ground_checker"):
            vars(made)[name] = getattr(problem, name)
    return made


def goal(case: Case, generator: Generator) -> Fault | None:
    """Move one target of the goal away from where the plan ends, by 1.01 tolerances."""
    known = case.judge.knows
    wanted, final = case.problem.goal, case.chained[-1] if known else case.motion.x[-1]
    if not np.isfinite(final).all():
        return None
    count = len(wanted.indices)
    i = int(generator.integers(count + len(wanted.parts) + len(wanted.directions)))
    far = float(case.judge.apart(final, case.motion.x[-1]).max()) > NEAR
    truth = ("borderline" if far else "false") if known else "unknown"
    verdict = Verdict(truth, f"{MISSED} tolerances from the goal")
    if i < count:
        targets, sign = np.array(wanted.targets), generator.choice([-1.0, 1.0])
        targets[i] = final[wanted.indices[i]] + sign * MISSED * wanted.tolerances[i]
        moved = replace(wanted, targets=targets)
        what = f"{case.judge.states[wanted.indices[i]]} of the goal is missed"
    elif i < count + len(wanted.parts):
        one = wanted.parts[i - count]
        turn = _turn(generator, min(MISSED * one.tolerance, np.pi))
        x, y, z, w = map(float, (Rotation.from_quat(final[one.part.own]) * turn).as_quat())
        rest = [other for other in wanted.parts if other is not one]
        moved = replace(wanted, parts=(*rest, replace(one, target=(x, y, z, w))))
        what = f"the attitude {one.part.name} of the goal is missed"
    else:
        axis = wanted.directions[i - count - len(wanted.parts)]
        seen = case.bodies.poses(final)[axis.body][:3, :3] @ np.array(axis.axis)
        aside = np.cross(seen, generator.normal(size=3))
        turn = Rotation.from_rotvec(MISSED * axis.tolerance * aside / np.linalg.norm(aside))
        aims = [other for other in wanted.directions if other is not axis]
        x, y, z = map(float, turn.apply(seen))
        moved = replace(wanted, directions=(*aims, replace(axis, target=(x, y, z))))
        what = "the direction of the goal is missed"
    return Fault(like(case.problem, goal=moved), case.motion, verdict, what)


def _turn(generator: Generator, angle: float) -> Rotation:
    axis = generator.normal(size=3)
    return Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))


def _state_between(case: Case, k: int, share: float) -> tuple[float, Array]:
    """Return a time within an interval and the judge's state there; at a row without an oracle."""
    motion = case.motion
    if not case.judge.knows:
        return float(motion.t[k]), motion.x[k]
    time = share * float(motion.t[k + 1] - motion.t[k])
    return float(motion.t[k]) + time, case.judge.after(motion.x[k], motion.u[k], time)


def obstacle(case: Case, generator: Generator) -> Fault | None:
    """Move an obstacle into a body: by the distance at some time, and a millimetre more.

    Where plans keep a clearance, it is moved to a millimetre less than that. Of some times the one
    is taken at which a pair of places is nearest. The pair's place on the obstacle is then within
    the body, or nearer to it than the clearance.
    """
    obstacles = case.problem.world.obstacles
    if not obstacles or not case.steps:
        return None
    chosen = obstacles[int(generator.integers(len(obstacles)))]
    still, best = Still(chosen), None
    for _ in range(LOOKS if len(chosen.faces) < 2000 else 3):
        k = int(generator.integers(case.steps))
        t, x = _state_between(case, k, float(generator.uniform(0.05, 0.95)))
        solids = case.bodies.solids(x)
        solid = solids[int(generator.integers(len(solids)))]
        there, here = nearest_pair(still, solid)
        gap = float(np.linalg.norm(here - there))
        if gap > 1e-9 and (best is None or gap < best[0]):
            best = gap, t, there, here, solid
    if best is None:
        return None
    gap, t, there, here, solid = best
    kept = case.problem.world.clearance
    by = (here - there) / gap * (gap - kept + INTO)
    return _moved_in(case, chosen, there, by, solid, t)


def _moved_in(
    case: Case, chosen: Obstacle, there: Array, by: Array, solid: Solid, t: float
) -> Fault:
    """Return the fault of one obstacle moved, alone in its world."""
    kept = case.problem.world.clearance
    place = there + by
    overlap = solid.depth(place)
    if overlap < 0:  # outside: by how much less than the clearance it is away
        overlap = kept - float(np.linalg.norm(solid.nearest(place) - place))
    else:
        overlap += kept
    primitive = chosen.primitive
    if primitive is not None:
        pose = np.array(primitive[1])
        pose[:, 3] += by
        primitive = primitive[0], pose
    moved = replace(chosen, vertices=chosen.vertices + by, primitive=primitive)
    world = World((moved,), ground=False, bounds=case.problem.world.bounds, clearance=kept)
    truth = "false" if overlap > SURE else "borderline"
    verdict = Verdict(truth, f"it overlaps by {1000 * overlap:.3g} mm at t = {t:.6g} s")
    what = f"{chosen.name} moved by {1000 * float(np.linalg.norm(by)):.4g} mm"
    return Fault(like(case.problem, world=world), case.motion, verdict, what)


def wall(case: Case, generator: Generator) -> Fault | None:
    """Put a wall of a millimetre through a body at a time between two rows, and nothing else."""
    if not case.steps:
        return None
    k = int(generator.integers(case.steps))
    t, x = _state_between(case, k, float(generator.uniform(0.05, 0.95)))
    solids = case.bodies.solids(x)
    solid = solids[int(generator.integers(len(solids)))]
    middle = solid.inner(generator)
    deep = float(generator.uniform(SHALLOWEST, max(solid.depth(middle), SHALLOWEST)))
    middle = _towards_the_surface(solid, middle, deep)
    turn = Rotation.random(random_state=int(generator.integers(2**31)))
    width = float(10 ** generator.uniform(*np.log10(WIDTHS)))
    rpy = tuple(turn.as_euler("xyz"))
    sheet = box_obstacle("sheet", (SHEET, width, width), tuple(middle), rpy)
    world = World((sheet,), ground=False, bounds=case.problem.world.bounds)
    depth = solid.depth(middle)
    truth = "false" if depth > SURE else "borderline"
    verdict = Verdict(truth, f"its middle is {1000 * depth:.3g} mm within at t = {t:.6g} s")
    what = f"a wall of {1000 * width:.3g} mm in the way at t = {t:.6g} s"
    return Fault(like(case.problem, world=world), case.motion, verdict, what)


def _towards_the_surface(solid: Solid, place: Array, deep: float) -> Array:
    """Return a place that is only so deep in a shape, on the line from its centre."""
    centre, out = solid.centre, place - solid.centre
    if float(np.linalg.norm(out)) < 1e-9:
        return place
    low, high = 1.0, 1.0
    while solid.depth(centre + high * out) > deep:
        low, high = high, 2 * high
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if solid.depth(centre + middle * out) > deep else (low, middle)
    return np.asarray(centre + low * out)


KINDS: dict[str, Kind] = {"goal": goal, "obstacle": obstacle, "thin wall": wall}
