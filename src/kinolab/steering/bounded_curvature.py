"""Cars of bounded curvature, whose shortest motions are curves of Dubins, Reeds and Shepp.

Which machines they are is seen in their equations alone: a pose x, y, psi of the plane changes by

    x' = v(u) cos psi,    y' = v(u) sin psi,    psi' = w(u),    |w(u)| <= |v(u)| / R

for all inputs u, and v is largest straight ahead as well as along both tightest turns.

Sources: Dubins, On curves of minimal length with a constraint on average curvature, American J.
Mathematics 79, 1957; Reeds, Shepp, Optimal paths for a car that goes both forwards and backwards,
Pacific J. Mathematics 145(2), 1990.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.steering.cyclic_coordinates import cyclic_coordinates
from kinolab.steering.reeds_shepp import Arc, PlanePose, arcs, lengths

ROUNDING = 1e-9  # relative to the largest rate
FORWARD, BACKWARD = 1, -1
STRAIGHT, LEFT, RIGHT = 0, 1, -1
SIDES = (STRAIGHT, LEFT, RIGHT)


@dataclass(frozen=True)
class CurvatureCar:
    """A machine that drives along every curve of bounded curvature, and along no other.

    Attributes:
        entries: Of the state: x, y and the heading.
        radius: Of its tightest turn, in [m].
        speeds: Largest speed forward and, where it can, backward, in [m/s], by 1 and -1.
        inputs: For a gear and a side, to the left 1, to the right -1: the inputs (nu,).
    """

    entries: tuple[int, int, int]
    radius: float
    speeds: Mapping[int, float]
    inputs: Mapping[tuple[int, int], Array]

    def pose(self, x: Array) -> PlanePose:
        """Return where a state, shape (nx,), is in the plane."""
        px, py, heading = x[list(self.entries)].tolist()
        return px, py, heading

    def seconds(self, arc: Arc) -> float:
        """Return how long an arc takes, in [s]."""
        return abs(arc.length) / self.speeds[self._gear(arc)]

    def input(self, arc: Arc) -> Array:
        """Return the inputs (nu,) along an arc."""
        return self.inputs[self._gear(arc), int(np.sign(arc.curvature))]

    def curves(self, begin: PlanePose, end: PlanePose) -> list[list[Arc]]:
        """Return the shortest curves between two poses, forward and any, the quickest first."""
        kinds = (True, False) if BACKWARD in self.speeds else (False,)
        found = [arcs(begin, end, self.radius, backward=kind) for kind in kinds]
        return sorted(found, key=lambda curve: sum(map(self.seconds, curve)))

    def all_seconds(self, poses: Sequence[PlanePose]) -> Array:
        """Return how long the quickest curves between all poses take, in [s], shape (n, n)."""
        paces = {kind == BACKWARD: speed for kind, speed in self.speeds.items()}
        kinds = [lengths(poses, self.radius, backward=kind) / pace for kind, pace in paces.items()]
        return np.asarray(np.min(kinds, axis=0))

    def _gear(self, arc: Arc) -> int:
        return FORWARD if arc.length >= 0.0 else BACKWARD


def curvature_car(problem: PlanningTask) -> CurvatureCar | None:
    """Return a machine as a car of bounded curvature; None where it is none.

    None, too, where the goal is no pose of the plane. What neither matters nor is asked for, such
    as how far wheels have rolled, may be among its coordinates.
    """
    model, goal = problem.model, problem.goal
    own = model.nv or problem.machine.states or problem.machine.modes
    if own or model.plant is not model or not np.isfinite(model.control_bounds).all():
        return None
    if problem.scenario.integration.truth == "discrete":
        return None
    entries = np.flatnonzero(~cyclic_coordinates(problem)).tolist()
    if len(entries) != 3 or sorted(goal.indices) != entries or goal.needs_frames:
        return None
    if problem.space.spheres or problem.machine.requirements:
        return None
    for place in permutations(entries):
        if problem.circular[place[2]] and (car := _car_at(problem, place)):
            return car
    return None


def _car_at(problem: PlanningTask, entries: tuple[int, ...]) -> CurvatureCar | None:
    """Return the car whose pose such entries of the state are, None if they are none of a car."""
    model, generator = problem.model, np.random.default_rng(0)
    lower, upper = model.control_bounds.T
    kinds = np.column_stack([model.control_bounds, model.null_control()])
    letters = np.array(list(product(*kinds)))
    # 30 states and inputs that show what the equations are
    drawn = generator.uniform(lower, upper, (30, model.nu))
    u = np.vstack([letters, drawn])
    rates = _rates(problem, entries, u, generator)
    if rates is None:
        return None
    speed, turn = rates
    gears: dict[int, tuple[float, float, dict[int, Array]]] = {}
    for gear in (FORWARD, BACKWARD):
        found = _gear(letters, gear * speed[: len(letters)], gear * turn[: len(letters)])
        if found is not None:
            gears[gear] = found
    if FORWARD not in gears:
        return None
    sharpest = gears[FORWARD][1]
    alike = {k: g for k, g in gears.items() if abs(g[1] - sharpest) <= ROUNDING * sharpest}
    if (np.abs(turn) > sharpest * (np.abs(speed) + ROUNDING * gears[FORWARD][0])).any():
        return None  # it turns tighter when it is slower, or on the spot
    return CurvatureCar(
        (entries[0], entries[1], entries[2]),
        1.0 / sharpest,
        {k: pace for k, (pace, _, _) in alike.items()},
        {(k, side): u for k, (_, _, sides) in alike.items() for side, u in sides.items()},
    )


def _rates(
    problem: PlanningTask, entries: Sequence[int], u: Array, generator: np.random.Generator
) -> tuple[Array, Array] | None:
    """Return speeds in [m/s] and turn rates in [rad/s] under inputs (m, nu), shape (m,) each.

    None where it slips sideways, or these depend on the state.
    """
    both: list[tuple[Array, Array]] = []
    for _ in range(2):
        x = np.stack([problem.sample(generator) for _ in u])
        fx, fy, turn = problem.model.f(x, u)[:, list(entries)].T
        c, s = np.cos(x[:, entries[2]]), np.sin(x[:, entries[2]])
        size = np.abs([fx, fy, turn]).max()
        if not np.abs(fy * c - fx * s).max() <= ROUNDING * size:
            return None
        both.append((fx * c + fy * s, turn))
    (v, w), (v2, w2) = both
    alike = np.abs([v - v2, w - w2]).max() <= ROUNDING * max(np.abs([v, w]).max(), 1e-300)
    return (v, w) if alike else None


def _gear(
    letters: Array, speed: Array, turn: Array
) -> tuple[float, float, dict[int, Array]] | None:
    """Return the largest speed, the sharpest curvature and its letters; None if it has no such.

    Curvatures are by the distance gone in this gear, whose sign the arc of a curve has: a turn to
    the left is one to the left both forward and backward.
    """
    pace = float(speed.max())
    fast = np.flatnonzero(speed >= pace * (1.0 - ROUNDING))
    if pace <= 0.0:
        return None
    bends = turn[fast] / pace
    sharpest = float(np.abs(bends).max())
    sides: dict[int, Array] = {}
    for side in SIDES:
        nearest = int(np.abs(bends - side * sharpest).argmin())
        if not abs(bends[nearest] - side * sharpest) <= ROUNDING * sharpest:
            return None
        sides[side] = letters[fast[nearest]]
    return (pace, sharpest, sides) if sharpest > 0.0 else None
