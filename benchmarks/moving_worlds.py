"""Plans among obstacles that move, and the same plans where these move otherwise, judged by FCL.

    python benchmarks/moving_worlds.py [--seeds 10] [--faults 1000] [--worlds NAME ...]

A gate, a revolving door, crossing traffic and a conveyor, each for several machines, planned with
``auto`` for 30 s at most. Where a plan is found, FCL looks at poses every millisecond. Then the
obstacles come later by up to 5 %, move faster by up to 3 % or begin elsewhere, and the certificate
is asked again; what FCL sees there is the truth. Motions that come nearer than points move in half
a millisecond are left out: they are neither. Returns 1 where a plan is missing or a verdict wrong.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import fcl
import numpy as np
from scipy.spatial.transform import Rotation

import kinolab
from kinolab.dynamics.language.shapes import ShapeKind
from kinolab.numerics.arrays import Array
from kinolab.simulation.reference import DivergedError, resimulate
from kinolab.trajectory import Trajectory
from kinolab.verification import verify
from kinolab.world.shapes.geometry import placement, sizes

SAMPLE = 1e-3  # [s] between two looks
LIMIT = 30.0  # [s] for a first plan
Pose = tuple[Array, Array]  # places (n, 3) and yaws (n,) at times


@dataclass(frozen=True)
class Mover:
    """A box that moves: its edges in [m], and rows of t, x, y, z, yaw, which repeat."""

    edges: tuple[float, float, float]
    rows: tuple[tuple[float, float, float, float, float], ...]
    repeat: bool = True

    def table(self, late: float, fast: float, off: float) -> list[list[float]]:
        """Return the rows of a motion that is later, faster, and begins elsewhere along x and y."""
        return [
            [t * (1 + late) / (1 + fast), x + off, y + off, z, 0.0, 0.0, yaw]
            for t, x, y, z, yaw in self.rows
        ]


def gate() -> tuple[list[dict[str, Any]], list[Mover]]:
    """A gap that is shut for 4 s and open for 2 s."""
    shut, open_ = (3.0, 1.5, 0.5, 0.0), (3.0, 2.8, 0.5, 0.0)
    rows = ((0.0, *shut), (4.0, *shut), (5.0, *open_), (7.0, *open_), (8.0, *shut))
    return walls(3.0, 0.85), [Mover((0.2, 1.4, 1.0), rows)]


def door() -> tuple[list[dict[str, Any]], list[Mover]]:
    """Two wings that turn in a gap, once in 12 s."""
    rows = tuple((12.0 * k / 8, 3.0, 1.5, 0.5, 2 * np.pi * k / 8) for k in range(9))
    return walls(3.0, 1.05), [Mover((1.9, 0.1, 1.0), rows)]


def traffic() -> tuple[list[dict[str, Any]], list[Mover]]:
    """Three that cross to and fro, at different speeds."""
    cars = []
    for x, period, begin in ((2.2, 5.0, 0.5), (3.0, 7.0, 2.5), (3.8, 6.0, 1.2)):
        near, far, half = (x, begin, 0.5, 0.0), (x, 3.0 - begin, 0.5, 0.0), period / 2
        cars.append(Mover((0.5, 0.9, 1.0), ((0.0, *near), (half, *far), (period, *near))))
    return [], cars


def conveyor() -> tuple[list[dict[str, Any]], list[Mover]]:
    """Five on a belt across the way, 1.3 m apart, that come again and again."""
    return [], [
        Mover((0.5, 0.5, 0.5), ((0.0, 3.0, y, 0.25, 0.0), (60.0, 3.0, y + 24.0, 0.25, 0.0)), False)
        for y in np.arange(-24.0, 3.0, 1.3).tolist()
    ]


def walls(x: float, half: float) -> list[dict[str, Any]]:
    """Return a wall across the way with a gap in its middle."""
    length = 1.5 - half
    return [
        {"name": f"wall {k}", "box": [0.25, length, 1.0], "position": [x, y, 0.5]}
        for k, y in enumerate((length / 2, 3.0 - length / 2))
    ]


WORLDS: dict[str, Callable[[], tuple[list[dict[str, Any]], list[Mover]]]] = {
    made.__name__: made for made in (gate, door, traffic, conveyor)
}
MACHINES: dict[str, dict[str, Any]] = {
    "rolling_disk": {  # three velocities for two inputs, and it never slides sideways
        "system": {"name": "rolling_disk", "parameters": {"R": 0.2}},
        "metric": {"psi": 0.5, "phi": 0.001, "psi_dot": 0.1, "phi_dot": 0.1},
        "integration": {"step": 0.05},
    },
    "unicycle2_v0": {"system": {"name": "unicycle2_v0"}, "integration": {"step": 0.1}},
    "diff_drive": {
        "system": {"name": "diff_drive"},
        "bounds": {"phi_l_dot": [-8, 8], "phi_r_dot": [-8, 8]},
        "metric": {"psi": 0.3, "phi_l": 0.001, "phi_r": 0.001},
        "integration": {"step": 0.1},
    },
}


def problem_of(
    world: str, machine: str, late: float = 0.0, fast: float = 0.0, off: float = 0.0
) -> tuple[kinolab.Problem, list[tuple[Mover, list[list[float]]]]]:
    """Return a problem, and what moves in it with its rows."""
    standing, movers = WORLDS[world]()
    moving = [(one, one.table(late, fast, off)) for one in movers]
    table: dict[str, Any] = deepcopy(MACHINES[machine])
    ground = {} if machine == "unicycle2_v0" else {"ground": "plane"}
    told = [
        {
            "name": f"mover {k}",
            "box": list(one.edges),
            "motion": {"points": rows} | ({"repeat": True} if one.repeat else {}),
        }
        for k, (one, rows) in enumerate(moving)
    ]
    table["world"] = {
        "bounds": {"x": [0, 6], "y": [0, 3]},
        "obstacle": [*standing, *told],
        **ground,
    }
    table["start"], table["goal"] = {"x": 1.0, "y": 1.5}, {"x": 5.0, "y": 1.5}
    return kinolab.load(table), moving


class Judge:
    """Looks at poses with FCL, and knows of obstacles only their boxes and rows."""

    def __init__(
        self, problem: kinolab.Problem, moving: Sequence[tuple[Mover, list[list[float]]]]
    ) -> None:
        self._problem, self._moving = problem, moving
        self._shapes = [
            (k, placement(shape), _solid(shape))
            for k, body in enumerate(problem.bodies)
            if not body.prescribed
            for shape in body.shapes
        ]
        self._standing = [
            fcl.CollisionObject(fcl.Box(*entry.box), fcl.Transform(np.array(entry.position)))
            for entry in problem.scenario.world.obstacle
            if entry.motion is None
        ]
        self._boxes = [fcl.CollisionObject(fcl.Box(*one.edges)) for one, _ in moving]

    def least(self, times: Array, x: Array) -> float:
        """Return the least distance to what moves or stands, 0 where something touches."""
        poses = self._problem.frames(x).reshape(len(x), -1, 3, 4)
        places = [_at(rows, times, repeat=one.repeat) for one, rows in self._moving]
        best = np.inf
        for k in range(len(times)):
            for box, (place, yaw) in zip(self._boxes, places, strict=True):
                box.setTransform(
                    fcl.Transform(Rotation.from_euler("z", yaw[k]).as_matrix(), place[k])
                )
            for body, own, solid in self._shapes:
                turn = poses[k, body, :, :3]
                at = turn @ own[:, 3] + poses[k, body, :, 3]
                solid.setTransform(fcl.Transform(turn @ own[:, :3], at))
                for box in (*self._boxes, *self._standing):
                    near = np.linalg.norm(at - box.getTranslation()) < NEAR
                    if near and fcl.collide(solid, box):
                        return 0.0
                    if near:
                        best = min(best, fcl.distance(solid, box))
        return float(best)


NEAR = 3.0  # [m] between centres from which on nothing touches here


def _solid(shape: Any) -> fcl.CollisionObject:
    kind, half = sizes(shape)
    if kind is ShapeKind.CYLINDER:
        return fcl.CollisionObject(fcl.Cylinder(half[0], 2.0 * half[2]))
    if kind is ShapeKind.SPHERE:
        return fcl.CollisionObject(fcl.Sphere(half[0]))
    if kind is ShapeKind.CAPSULE:
        return fcl.CollisionObject(fcl.Capsule(half[0], 2.0 * half[2]))
    return fcl.CollisionObject(fcl.Box(*(2.0 * half[:3])))


def _at(rows: list[list[float]], times: Array, *, repeat: bool) -> Pose:
    table = np.array(rows)
    within = times % table[-1, 0] if repeat else times
    columns = [np.interp(within, table[:, 0], values) for values in table[:, 1:].T]
    return np.stack(columns[:3], axis=1), columns[5]


def densely(problem: kinolab.Problem, motion: Trajectory) -> tuple[Array, Array]:
    """Return the times and states of a motion every millisecond."""
    t, u = motion.t, motion.inputs
    times = np.unique(np.concatenate([t, np.arange(0.0, t[-1], SAMPLE)]))
    held = u[np.clip(np.searchsorted(t, times[:-1], "right") - 1, 0, len(u) - 1)]
    return times, resimulate(problem, times, held).x


def main(arguments: Sequence[str] | None = None) -> int:
    """Plan, change what moves, and compare verdicts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--faults", type=int, default=1000)
    parser.add_argument("--worlds", nargs="*", default=[*WORLDS], choices=[*WORLDS])
    given = parser.parse_args(arguments)
    wrong, verdicts = 0, {(a, b): 0 for a in (True, False) for b in (True, False)}
    undecided, rng = 0, np.random.default_rng(0)
    cases = [(world, machine) for world in given.worlds for machine in MACHINES]
    each = max(1, given.faults // max(1, len(cases) * given.seeds))
    for world, machine in cases:
        problem, moving = problem_of(world, machine)
        took, durations, least = [], [], np.inf
        for seed in range(1, given.seeds + 1):
            begun = time.perf_counter()
            plan = problem.solve(seed=seed, improve=0, time_limit=LIMIT)
            took.append(time.perf_counter() - begun)
            if plan.status != "solved" or plan.trajectory is None:
                wrong += 1
                continue
            durations.append(plan.trajectory.duration)
            times, x = densely(problem, plan.trajectory)
            least = min(least, Judge(problem, moving).least(times, x))
            for _ in range(each):
                late, fast, off = rng.choice([(0.05, 0, 0), (0, 0.03, 0), (0, 0, 0.1)])
                share = rng.uniform()
                other, moved = problem_of(world, machine, late * share, fast * share, off * share)
                try:
                    said = verify(other, plan.trajectory).passed
                except DivergedError:
                    said = False
                true = Judge(other, moved).least(times, x)
                if 0.0 < true < GRAZE:
                    undecided += 1
                else:
                    verdicts[bool(said), true > 0.0] += 1
        print(
            f"{world:9} {machine:13} solved {len(durations)} of {given.seeds}, "
            f"{np.median(took):.2f} s (at most {max(took):.2f} s), motions of "
            f"{np.median(durations or [np.nan]):.1f} s, least distance {1000 * least:.1f} mm",
        )
        print(f"          so far: {_told(verdicts)}, {undecided} too near to tell", flush=True)
        wrong += int(not least > 0.0)
    return int(bool(wrong or verdicts[True, False] or verdicts[False, True]))


def _told(verdicts: dict[tuple[bool, bool], int]) -> str:
    return (
        f"{verdicts[False, False]} false refused, {verdicts[True, False]} false accepted, "
        f"{verdicts[True, True]} true accepted, {verdicts[False, True]} true refused"
    )


GRAZE = 2e-3  # [m], in half a millisecond at 4 m/s: what comes so near may touch between two looks

if __name__ == "__main__":
    sys.exit(main())
