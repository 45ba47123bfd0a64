"""Obstacles that move: bodies of the machine that time alone moves, so that all else knows them.

With a clock among its coordinates a machine's state space is X times T. An obstacle whose pose is a
function of time is then one more body, which meets those of the machine and nothing else: searches,
optimiser, certificate and pictures treat the pair as they treat any two bodies.

Source: LaValle, Planning Algorithms, 2006, section 7.1 (time-varying problems).
"""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from kinolab.dynamics import Model
from kinolab.errors import InputError
from kinolab.numerics.arrays import Array
from kinolab.problem.task import HORIZON
from kinolab.scenario import Issue, ObstacleEntry, Scenario, mistake_at
from kinolab.untrusted import text_file, why
from kinolab.world.obstacle import Obstacle

if TYPE_CHECKING:
    import sympy

    from kinolab.dynamics.language.mechanism import Mechanism
    from kinolab.dynamics.language.shapes import Shape

TIME = "time"  # what the coordinate is called
LONGEST = 600.0  # [s] for which rows are repeated, without [bounds] time
COLUMNS = ("t", "x", "y", "z", "roll", "pitch", "yaw")  # of a file; the last three can be missing
MOST_CORNERS = 400  # of an obstacle's path: each is an operation of the machine's code
SAMPLES = 1000  # of a motion, among which the fastest is taken
CHORD = 1e-3  # [m] or [rad] between a path in a file and its chords


def among_moving(model: Model, scenario: Scenario, obstacles: Sequence[Obstacle]) -> Model:
    """Return a machine among the obstacles that move, the time being a further coordinate.

    Args:
        model: The machine.
        scenario: Says how obstacles move.
        obstacles: Those that move, each with its own origin in that of the world.

    Raises:
        InputError: With all that is wrong with their motions.
    """
    moving = [(k, e) for k, e in enumerate(scenario.world.obstacle) if e.motion is not None]
    horizon = scenario.bounds.get(TIME, (0.0, LONGEST))[1]
    points = [_points(scenario, k, entry, horizon) for k, entry in moving]
    if TIME in (*model.state_names, *model.control_names):
        what = f"the machine calls something {TIME!r}, which is the time where obstacles move."
        raise InputError([mistake_at(Issue(("world", "obstacle"), what), scenario.origin)])
    told = [entry.model_dump(mode="json") for _, entry in moving]
    corners = [None if one is None else one.tolist() for one in points]
    meshes = [[o.vertices.tolist() for o in obstacles if o.primitive is None]]
    content = json.dumps([model.key, TIME, horizon, told, corners, meshes])
    make = partial(_described, model, scenario, moving, points, obstacles, horizon)
    return Model.described_by(content, make)


def _described(
    model: Model,
    scenario: Scenario,
    moving: Sequence[tuple[int, ObstacleEntry]],
    points: Sequence[Array | None],
    obstacles: Sequence[Obstacle],
    horizon: float,
) -> Mechanism:
    """Return the machine with a clock, and a body for each obstacle that moves."""
    import sympy

    from kinolab.dynamics.language.bodies import Body
    from kinolab.dynamics.language.frames import move, rot_x, rot_y, rot_z
    from kinolab.dynamics.language.symbols import clock

    system, t = model.system, sympy.Symbol("t", real=True)
    given = zip(moving, points, strict=True)
    poses = [_pose(scenario, k, entry, corners, t) for (k, entry), corners in given]
    fastest = max(_fastest(pose, t, horizon) for pose in poses)
    # A second counts as far as the fastest obstacle moves in it.
    time = clock(TIME, scale=1.0 / fastest if fastest > 0.0 else HORIZON)
    bodies = []
    for (_, entry), pose, obstacle in zip(moving, poses, obstacles, strict=True):
        x, y, z, roll, pitch, yaw = (entry.xreplace({t: time}) for entry in pose)
        frame = move(x, y, z) @ rot_z(yaw) @ rot_y(pitch) @ rot_x(roll)
        color = entry.colors[0] if entry.colors else None
        bodies.append(
            Body(entry.name, frame, shape=_shape(obstacle), prescribed=True, color=color)
        )
    parts = [body.name for body in system.bodies if body.shapes]
    parts += [cable.name for cable in system.cables if cable.collides]
    pairs = [(part, body.name) for body in bodies for part in parts]
    return system.changed(
        bodies=[*system.bodies, *bodies],
        collisions=[*system.collisions, *pairs],
        coordinates=[*system.coordinates, time],
        flat=None,
    )


def _shape(obstacle: Obstacle) -> Shape:
    """Return the solid of an obstacle, of a mesh its convex hull."""
    if obstacle.primitive is not None:
        return obstacle.primitive[0]
    from scipy.spatial import ConvexHull

    from kinolab.dynamics.language.shapes import Hull
    from kinolab.dynamics.language.shapes.packed_rows import packed

    middle = np.mean(obstacle.bounding_box(), axis=0)
    corners = obstacle.vertices[ConvexHull(obstacle.vertices).vertices] - middle
    return Hull("mesh", packed(corners, "<f8"), at=tuple(middle.tolist()))


def _pose(
    scenario: Scenario, k: int, entry: ObstacleEntry, corners: Array | None, t: sympy.Symbol
) -> tuple[sympy.Expr, ...]:
    """Return x, y, z, roll, pitch and yaw of an obstacle as functions of time."""
    import sympy

    from kinolab.problem.objective.formula import formula_in

    motion, still = entry.motion, tuple(map(sympy.Float, (*entry.position, *entry.rpy)))
    assert motion is not None
    if corners is not None:
        made = [_polyline(corners[:, 0], values, t) for values in corners[:, 1:].T]
        return (*made, *still[len(made) :])
    if motion.position is None and motion.rpy is None:
        rates = (*motion.velocity, *motion.spin)
        return tuple(at + t * rate for at, rate in zip(still, rates, strict=True))
    found = list(still)
    for key, first in (("position", 0), ("rpy", 3)):
        for i, text in enumerate(getattr(motion, key) or ()):
            where = f"{scenario.origin.file.name} [[world.obstacle]] {k + 1} motion {key}"
            found[first + i] = formula_in(text, {"t": t}, where)
    return tuple(found)


def _polyline(times: Array, values: Array, t: sympy.Symbol) -> sympy.Expr:
    """Return the function that is linear between its corners, and constant before and after."""
    import sympy

    slopes = np.diff(values) / np.diff(times)
    kinks = np.diff(slopes, prepend=0.0, append=0.0)
    terms = [
        sympy.Float(kink) * sympy.Max(t - sympy.Float(time), 0, evaluate=False)
        for time, kink in zip(times, kinks, strict=True)
        if kink
    ]
    return sympy.Add(sympy.Float(values[0]), *terms)


def _fastest(pose: Sequence[sympy.Expr], t: sympy.Symbol, horizon: float) -> float:
    """Return the fastest that a point a metre from an obstacle's origin may be, in [m/s]."""
    import sympy

    times = np.linspace(0.0, horizon, SAMPLES)
    values = [np.broadcast_to(sympy.lambdify(t, e, "numpy")(times), times.shape) for e in pose]
    rates = np.diff(values, axis=1) / (times[1] - times[0])
    return float((np.linalg.norm(rates[:3], axis=0) + np.linalg.norm(rates[3:], axis=0)).max())


def _points(
    scenario: Scenario, k: int, entry: ObstacleEntry, horizon: float
) -> Array | None:
    """Return the corners of an obstacle's path, a row of time and pose each, where it has some."""
    motion = entry.motion
    assert motion is not None

    def refuse(key: str, what: str, remedy: str) -> InputError:
        issue = Issue(("world", "obstacle", k, "motion", key), what, remedy)
        return InputError([mistake_at(issue, scenario.origin)])

    if motion.points is not None:
        key, rows = "points", np.array(motion.points, dtype=float)
    elif motion.file is not None:
        key = "file"
        try:
            rows = np.array(list(_read(text_file(scenario.folder / motion.file))))
        except (OSError, ValueError, csv.Error) as error:
            remedy = f"Write a line of {', '.join(COLUMNS)}, then a row for each time."
            raise refuse(key, f"{motion.file}: {why(error)}.", remedy) from error
    else:
        return None
    if len(rows) < 2 or not (np.diff(rows[:, 0]) > 0.0).all():
        raise refuse(key, "its times do not rise.", "Give two rows or more, later ones after.")
    rows = _simplified(rows) if motion.file is not None else rows
    if motion.repeat:
        rows = _repeated(rows, horizon)
    if len(rows) > MOST_CORNERS:
        what = f"its path has {len(rows)} corners within {horizon:g} s."
        raise refuse(key, what, f"Leave some out, or write formulas: at most {MOST_CORNERS}.")
    return rows


def _read(text: str) -> Iterator[list[float]]:
    """Yield the rows of a table of poses.

    Raises:
        ValueError: If it is none.
    """
    table = csv.reader(text.splitlines())
    names = [name.strip() for name in next(table, [])]
    if names not in ([*COLUMNS], [*COLUMNS[:4]]):
        raise ValueError(f"its columns are {', '.join(names)[:80]}")
    for line, row in enumerate(table, start=2):
        values = [*map(float, row)]
        if len(values) != len(names) or not all(map(math.isfinite, values)):
            raise ValueError(f"line {line} is not a row of {len(names)} finite numbers")
        yield values


def _simplified(rows: Array) -> Array:
    """Return fewer corners of a path that differs by at most ``CHORD`` from the whole.

    Source: Douglas, Peucker, Algorithms for the reduction of the number of points required to
    represent a digitized line, Cartographica 10(2), 1973.
    """
    kept, open_ = {0, len(rows) - 1}, [(0, len(rows) - 1)]
    while open_:
        a, b = open_.pop()
        share = ((rows[a : b + 1, 0] - rows[a, 0]) / (rows[b, 0] - rows[a, 0]))[:, None]
        chord = rows[a, 1:] + share * (rows[b, 1:] - rows[a, 1:])
        off = np.abs(rows[a : b + 1, 1:] - chord).max(axis=1)
        worst = int(off.argmax())
        if off[worst] > CHORD:
            kept.add(a + worst)
            open_ += [(a, a + worst), (a + worst, b)]
    return rows[sorted(kept)]


def _repeated(rows: Array, horizon: float) -> Array:
    """Return a path that begins anew whenever it ends, up to a time in [s]."""
    period = rows[-1, 0] - rows[0, 0]
    times = max(math.ceil((horizon - rows[0, 0]) / period), 1)
    parts = [rows[:1]]
    for n in range(min(times, MOST_CORNERS)):
        parts.append(rows[1:] + np.eye(1, rows.shape[1]) * n * period)
    return np.concatenate(parts)
