"""How a scenario's obstacles move: velocities, formulas in time, rows of poses."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from kinolab.dynamics import Model
from kinolab.dynamics.codegen.state_space import TURN, whole_turns
from kinolab.dynamics.facts.machine_facts import TIME
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.problem.task import HORIZON, PlanningTask
from kinolab.scenario import Issue, ObstacleEntry, Scenario, mistake_at
from kinolab.scenario.locations import place_at
from kinolab.scenario.toml_text import shortened
from kinolab.scenario.values import WHOLE_POSES
from kinolab.simulation.reference import resimulate
from kinolab.trajectory import read_csv
from kinolab.untrusted import text_file, why
from kinolab.world.obstacles.obstacle import ORIGIN, Obstacle

if TYPE_CHECKING:
    import sympy

    from kinolab.dynamics.language.mechanism import Mechanism
    from kinolab.dynamics.language.shapes import Shape

COLUMNS = ("t", "x", "y", "z", "roll", "pitch", "yaw")  # of a file; the angles may be left out
LONGEST = 600.0  # [s] for which rows are repeated, without [bounds] time
CHORD = 1e-3  # [m] between a path of many rows and straight lines, and kept beside obstacles


def among_moving(model: Model, scenario: Scenario, obstacles: Sequence[Obstacle]) -> Model:
    """Return a machine among the obstacles that move, the time being a further coordinate.

    Args:
        scenario: Says how obstacles move.
        obstacles: Those that move, each with its own origin in that of the world.

    Raises:
        InputError: With all that is wrong with their motions.
    """
    moving = [(k, e) for k, e in enumerate(scenario.world.obstacle) if e.motion is not None]
    given = scenario.bounds.get(TIME, (0.0, math.inf))[1]
    # A turn moves what is farthest from an obstacle's origin most.
    reaches = [float(np.linalg.norm(np.abs(o.bounding_box()).max(axis=0))) for o in obstacles]
    of_each = zip(moving, reaches, strict=True)
    points = [_points(scenario, k, entry, given, reach) for (k, entry), reach in of_each]
    # What begins anew does so until its corners are used up, and no motion may take longer.
    repeated = [e.motion is not None and e.motion.repeat for _, e in moving]
    pairs = zip(points, repeated, strict=True)
    horizon = min([given, *(float(p[-1, 0]) for p, again in pairs if again and p is not None)])
    if not model.clocks and TIME in (*model.state_names, *model.control_names):
        what = f"the machine calls something {TIME!r}, which is the time where obstacles move."
        raise InputError([mistake_at(Issue(("world", "obstacle"), what), scenario.origin)])
    told = [entry.model_dump(mode="json") for _, entry in moving]
    corners = [None if one is None else one.tolist() for one in points]
    meshes = [o.vertices.tolist() for o in obstacles if o.primitive is None]
    content = json.dumps([model.key, TIME, horizon, told, corners, meshes])
    made = list(zip(moving, points, obstacles, strict=True))
    return Model.described_by(content, partial(_described, model, scenario, made, horizon))


def path_error(scenario: Scenario) -> float:
    """Return by how much obstacles may be beside their paths in [m], as these are followed."""
    entries = scenario.world.obstacle
    long = any(e.run or (e.motion is not None and e.motion.file) for e in entries)
    return CHORD if long else 0.0


def among_runs(model: Model, scenario: Scenario, load: Callable[[Path], PlanningTask]) -> Model:
    """Return a machine among those of other plans that a scenario names, which move as was planned.

    Args:
        load: Returns the problem of a scenario's file.

    Raises:
        InputError: If there is no such plan.
    """
    named = [(k, e) for k, e in enumerate(scenario.world.obstacle) if e.run is not None]
    if not named:
        return model
    mistakes: list[Mistake] = []
    planned = []
    for k, entry in named:
        try:
            planned.append((entry, *_planned(scenario.folder / str(entry.run), load)))
        except (InputError, OSError) as error:
            what = f"{entry.run} has no plan: {why(error).rstrip('.')}."
            remedy = "Plan there first, or name the folder of another run."
            issue = Issue(("world", "obstacle", k, "run"), what, remedy)
            mistakes.append(mistake_at(issue, scenario.origin))
    if mistakes:
        raise InputError(mistakes)
    told = [[e.name, task.model.key, x.tolist()] for e, task, _, x in planned]
    content = json.dumps([model.key, "among runs", told])
    return Model.described_by(content, partial(_among_planned, model, planned))


def _planned(
    folder: Path, load: Callable[[Path], PlanningTask]
) -> tuple[PlanningTask, Array, Array]:
    """Return the problem of a run, and the states of its motion at times (n,), (n, nx)."""
    task = load(folder / "scenario.toml")
    plant, laws = task.model.plant, task.machine.references or ()
    names = (task.model.state_names, plant.control_names, tuple(r.name for r in laws))
    motion = read_csv(folder / "trajectory.csv", *names)
    times = np.unique(np.concatenate([motion.t, np.arange(0.0, motion.duration, task.step / 4)]))
    held = motion.inputs[np.clip(np.searchsorted(motion.t, times[:-1], "right") - 1, 0, None)]
    return task, times, resimulate(task, times, held).x


def _among_planned(
    model: Model, planned: Sequence[tuple[ObstacleEntry, PlanningTask, Array, Array]]
) -> Mechanism:
    from kinolab.dynamics.language.json.machine_file import machine_to_json
    from kinolab.dynamics.language.json.size_limits import size_mistakes
    from kinolab.dynamics.movers import Mover, among, corners_of, fastest_between, polyline

    movers, fastest = [], 0.0
    for entry, task, times, x in planned:
        poses = task.model.frames(x).reshape(len(times), -1, 3, 4)
        color = entry.colors[0] if entry.colors else None
        for k, body in enumerate(task.bodies):
            if body.shapes:
                corners = corners_of(body.shapes, times, poses[:, k], CHORD)
                name = f"{entry.name} {body.name}"
                movers.append(Mover(name, body.shapes, polyline(corners), color or body.color))
                fastest = max(fastest, fastest_between(corners[:, 0], corners[:, 1:]))
    found = among(model.system, movers, fastest)
    if too_large := list(size_mistakes(json.loads(machine_to_json(found)))):
        what = f"with the motions of other plans, the machine is too large: {too_large[0].what}"
        raise InputError([Mistake("[[world.obstacle]] run", what, "Name fewer or shorter plans.")])
    return found


def _described(
    model: Model,
    scenario: Scenario,
    moving: Sequence[tuple[tuple[int, ObstacleEntry], Array | None, Obstacle]],
    horizon: float,
) -> Mechanism:
    from kinolab.dynamics.movers import Mover, among, fastest_of  # late: uses SymPy

    movers = [
        Mover(
            entry.name,
            (_shape(obstacle),),
            _pose(scenario, k, entry, corners, min(horizon, HORIZON)),
            entry.colors[0] if entry.colors else None,
        )
        for (k, entry), corners, obstacle in moving
    ]
    until = min(horizon, HORIZON)
    fastest = max(fastest_of(mover.pose, until) for mover in movers)
    found = among(model.system, movers, fastest, until=horizon)
    hulls = [f"{o.name} moves as its convex hull." for _, _, o in moving if not _convex(o)]
    units = [s for (_, e), corners, _ in moving for s in _units_meant(e.name, corners)]
    return found.changed(notes=[*found.notes, *(("", sentence) for sentence in hulls + units)])


def _units_meant(name: str, corners: Array | None) -> Iterator[str]:
    """Yield what looks like milliseconds or degrees in rows of a time and a pose each."""
    if corners is None:
        return
    times, angles = corners[:, 0], corners[:, 4:]
    if times[-1] > LONGEST and (times == times.round()).all():
        yield f"{name} moves for {times[-1] - times[0]:g} s; times in ms are to be divided by 1000."
    largest = float(np.abs(angles).max(initial=0.0))
    if largest > TURN and (angles == angles.round()).all():
        yield (
            f"{name} turns up to {largest:g} rad, in whole numbers and more than a whole turn; "
            f"{largest:g} degrees are {math.radians(largest):.4g} rad."
        )


def _convex(obstacle: Obstacle) -> bool:
    """Say whether an obstacle's faces are those of its convex hull, to a hundredth of its size."""
    if obstacle.primitive is not None:
        return True
    from scipy.spatial import ConvexHull

    hull, triangles = ConvexHull(obstacle.vertices), obstacle.vertices[obstacle.faces]
    inside = -(triangles.mean(axis=1) @ hull.equations[:, :3].T + hull.equations[:, 3])  # (m, k)
    # of a mesh's extent, by which a face may lie within its convex hull unsaid
    return bool(inside.min(axis=1).max() <= 0.01 * np.ptp(obstacle.vertices, axis=0).max())


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
    scenario: Scenario, k: int, entry: ObstacleEntry, corners: Array | None, until: float
) -> tuple[sympy.Expr, ...]:
    """Return x, y, z, roll, pitch and yaw of an obstacle as functions of time, finite up to one."""
    import sympy

    from kinolab.dynamics.movers import polyline, t
    from kinolab.dynamics.poles import first_pole
    from kinolab.problem.objective.formula import formula_in

    motion, still = entry.motion, (*entry.position, *entry.rpy)
    assert motion is not None
    if corners is not None:
        return polyline(corners, still[corners.shape[1] - 1 :])
    found = [*map(sympy.Float, still)]
    if motion.position is None and motion.rpy is None:
        rates = (*(motion.velocity or ORIGIN), *(motion.spin or ORIGIN))
        return tuple(at + t * rate for at, rate in zip(found, rates, strict=True))
    for key, first in (("position", 0), ("rpy", 3)):
        for i, text in enumerate(getattr(motion, key) or ()):
            where = place_at(("world", "obstacle", k, "motion", key), scenario.origin)
            found[first + i] = formula_in(text, {"t": t}, where)
            if (pole := first_pole(found[first + i], until)) is not None:
                what = f"{text!r} of {entry.name}, or its rate, is not finite at t = {pole:.6g} s."
                remedy = f"Write a formula that is finite and smooth from t = 0 to {until:g} s"
                remedy += f", or [bounds] time = [0, {0.9 * pole:.3g}]." if pole else "."
                raise InputError([Mistake(where, what, remedy)])
    return tuple(found)


def _points(
    scenario: Scenario, k: int, entry: ObstacleEntry, horizon: float, reach: float
) -> Array | None:
    """Return the corners of an obstacle's path, a row of time and pose each, where it has some.

    Args:
        scenario: Which says it.
        horizon: Time in [s] up to which rows are repeated.
        reach: How far the obstacle's points are from its origin at most, in [m].
    """
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
            remedy = (
                f"Write a line of {', '.join(COLUMNS)}, angles as needed, then a row for each time."
            )
            raise refuse(key, f"{motion.file}: {why(error)}.", remedy) from error
    else:
        return None
    if len(rows) < 2 or not (np.diff(rows[:, 0]) > 0.0).all():
        raise refuse(key, "its times do not rise.", "Give two rows or more, later ones after.")
    if rows.shape[1] == len(COLUMNS) and any(entry.rpy):
        raise refuse(key, "its rows have angles, and rpy is not used.", "Leave rpy out.")
    if motion.file is not None:
        from kinolab.dynamics.movers import simplified  # late: uses SymPy

        rows = simplified(rows, CHORD, np.array([1.0] * 3 + [reach] * 3)[: rows.shape[1] - 1])
    if motion.repeat and not _closes(rows):
        raise refuse(key, "it does not end where it begins.", "Add the first pose at the end.")
    if motion.repeat:
        rows = _repeated(rows, horizon)
    if len(rows) > WHOLE_POSES:
        what = f"its path has more than {WHOLE_POSES} corners"
        what += f" within {horizon:g} s." if motion.repeat else "."
        raise refuse(key, what, f"Leave some out, or write formulas: at most {WHOLE_POSES}.")
    return rows


def _read(text: str) -> Iterator[list[float]]:
    """Yield the rows of a table of poses.

    Raises:
        ValueError: If it is none.
    """
    table = csv.reader(text.splitlines())
    names = [name.strip() for name in next(table, [])]
    if len({*names}) < len(names) or not {*COLUMNS[:4]} <= {*names} <= {*COLUMNS}:
        raise ValueError(f"its columns are {', '.join(names)[:80]}")
    wanted = COLUMNS if {*names} & {*COLUMNS[4:]} else COLUMNS[:4]
    for row in filter(None, table):
        if len(row) != len(names):
            raise ValueError(f"line {table.line_num} has {len(row)} entries, not {len(names)}")
        given = {n: _number(n, cell, table.line_num) for n, cell in zip(names, row, strict=True)}
        yield [given.get(name, 0.0) for name in wanted]


def _number(column: str, cell: str, line: int) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        found = f"{shortened(cell)!r} is no finite number" if cell.strip() else "it is empty"
        raise ValueError(f"line {line}, column {column}: {found}")
    return value


def _closes(rows: Array) -> bool:
    """Say whether a path ends in the pose in which it begins, but for whole turns."""
    away = rows[-1, 1:] - rows[0, 1:]
    away[3:] -= whole_turns(away[3:])
    return bool(np.abs(away).max() <= 1e-6)  # [m] or [rad] between the ends of a path that repeats


def _repeated(rows: Array, until: float) -> Array:
    """Return a path that begins anew whenever it ends, up to a time in [s] or as long as it can."""
    period, most = rows[-1, 0] - rows[0, 0], (WHOLE_POSES - 1) // (len(rows) - 1)
    times = math.ceil((min(until, LONGEST) - rows[0, 0]) / period)
    if math.isinf(until):
        times = min(times, most)
    later = rows[-1] - rows[0]  # a period, and whole turns
    again = (rows[1:] + n * later for n in range(max(1, min(times, most + 1))))
    return np.concatenate([rows[:1], *again])
