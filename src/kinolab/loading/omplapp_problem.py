"""From a problem file of OMPL.app to a scenario, with the machine that its robot is."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kinolab.errors import InputError
from kinolab.loading.tables import OBJECT, Read
from kinolab.numerics.arrays import Array
from kinolab.scenario import Origin, apply_overrides, check_changed
from kinolab.scenario.load import readable
from kinolab.scenario.omplapp import CfgFile, CfgPose, CfgValue, ProblemFile, read_problem

if TYPE_CHECKING:
    from kinolab.dynamics import System
    from kinolab.robots.omplapp import PlacedMesh
    from kinolab.robots.tree.kinematic_tree import PlacedShape

CROSSING = 20.0  # [s] for the longest edge of the volume, of a body whose velocities are inputs
NEAR, NEARLY = (
    0.005,
    0.05,
)  # of that edge, and [rad]: the goal of such a body, reached exactly later
FREE_STEP, DRIVEN_STEP = 0.05, 0.1  # [s]


def read_problem_file(source: str | Path, *, overrides: Sequence[str] = ()) -> Read:
    """Read a problem file of OMPL.app as a scenario, and list its mistakes instead of raising them.

    Args:
        source: Path of the file; its meshes are in its folder.
        overrides: ``KEY=VALUE`` texts that replace keys of the scenario.

    Returns:
        The scenario, or None where the file has mistakes; and the mistakes.

    Raises:
        InputError: If there is no such file, or it is too long.
    """
    path = Path(source)
    problem, file = read_problem(path)
    table = file.table("problem")
    robot = _mesh(file, table.get("robot"), path.parent, centred=True)
    world = _mesh(file, table.get("world"), path.parent)
    if robot is not None and robot.count > 50_000:
        what = f"{table['robot'].text} has more than 50000 triangles."
        file.wrong(table["robot"], what, "Simplify it: solids that enclose it take its place.")
    if problem is not None and problem.control == "quadrotor":
        _check_hovering(file, problem.start, table)
    if file.found or problem is None or robot is None or world is None:
        return None, readable(file.mistakes, Origin(path))
    return _scenario(problem, robot, world, path, overrides)


def _mesh(
    file: CfgFile, value: CfgValue | None, folder: Path, *, centred: bool = False
) -> PlacedMesh | None:
    """Return a mesh, None where it has mistakes, which are added to those of the file.

    Args:
        file: That names it.
        folder: Of the file, which meshes may not leave.
        centred: Whether the mean of its vertices is asked for.
    """
    from kinolab.robots.omplapp import PlacedMesh  # late: it is here for these files alone

    if value is None:
        return None
    try:
        mesh = PlacedMesh(value.text, folder)
        if not centred or len(mesh.mean):
            return mesh
    except InputError as error:
        for mistake in error.mistakes:
            file.wrong(value, f"{mistake.where} {mistake.what}", mistake.remedy)
    return None


def _check_hovering(file: CfgFile, start: CfgPose, table: dict[str, CfgValue]) -> None:
    """Refuse a start from which OMPL.app's quadrotor falls faster than it may.

    With its z axis above the horizon, its thrust pushes it down. It cannot turn over before it
    falls faster than 1 m/s.
    """
    x, y, _, _ = start.quaternion
    if 1.0 - 2.0 * (x * x + y * y) < 0.0:  # the z component of the body's z axis
        return
    what = (
        "OMPL.app's quadrotor pushes along minus its z axis: so turned it falls, and soon faster "
        "than 1 m/s, where OMPL.app cuts its speed off. kinolab keeps to the equations."
    )
    remedy = "start.axis = 1, 0, 0 and start.theta = 3.14159 turn it over, so that it hovers."
    file.wrong(table["start.theta"], what, remedy)


def _scenario(
    problem: ProblemFile, robot: PlacedMesh, world: PlacedMesh, path: Path, overrides: Sequence[str]
) -> Read:
    from kinolab.robots.solids.interior_points import interior_points
    from kinolab.robots.solids.overhang import closest_solids

    centre = robot.mean.copy()
    if problem.axes == "xy":  # it keeps its height
        centre[2] = 0.0
    triangles = robot.triangles - centre
    solids, reach = closest_solids(triangles, interior_points(triangles))
    low, high = _bounds(problem, world)
    machine = _machine(problem, solids, float((high - low).max()))
    document = {
        "schema": 1,
        "title": f"{problem.name[:80]} (OMPL.app)",  # characters
        "system": dict(OBJECT),
        "world": {"obstacle": [world.entry]},
        "bounds": {
            q: [float(a), float(b)] for q, a, b in zip(problem.axes, low, high, strict=True)
        },
        **_ends(problem, float((high - low).max())),
        "metric": _metric(problem, triangles),
        "integration": {"step": DRIVEN_STEP if problem.control else FREE_STEP},
        "planner": _planner(problem),
        "render": {"view": "top" if problem.axes == "xy" else "perspective"},
    }
    fit = _fit(problem.robot.text, triangles, len(solids), reach)
    notes = (fit, *_left_out(problem), *problem.notes, *_planner_notes(problem))
    applied, mistakes = apply_overrides(document, overrides)
    return check_changed(document, Origin(path, applied, machine, notes), mistakes)


def _machine(problem: ProblemFile, solids: Sequence[PlacedShape], edge: float) -> System:
    """Return how the robot moves; freely, it crosses the edge of its volume in CROSSING."""
    from kinolab.robots.omplapp import parts_of
    from kinolab.systems import _rigid_bodies as machines

    parts = parts_of(solids)
    speed = edge / CROSSING
    if problem.space:
        forward = (0.0 if problem.space == "dubins" else -speed, speed)
        # The steering angle at which a car of the wheelbase R drives a circle of R
        return machines.kinematic_car(parts, forward, math.pi / 4, problem.radius)
    if not problem.control:
        free = machines.planar_body if problem.axes == "xy" else machines.free_body
        return free(parts, speed, 1.0)  # [rad/s] of such a body
    driven: System = getattr(machines, problem.control)(parts)  # the control is one of four
    return driven


def _bounds(problem: ProblemFile, world: PlacedMesh) -> tuple[Array, Array]:
    """Return lower and upper limits of the place, which start and goal widen where they must."""
    ends = np.array([problem.start.place, problem.goal.place])
    if problem.volume:
        low, high = np.array(problem.volume)
    else:
        corners = world.triangles.reshape(-1, 3)[:, : len(problem.axes)]
        low, high = corners.min(axis=0), corners.max(axis=0)
    return np.minimum(low, ends.min(axis=0)), np.maximum(high, ends.max(axis=0))


def _ends(problem: ProblemFile, edge: float) -> dict[str, Any]:
    """Return start and goal with its region."""
    rotation = _rotation(problem)
    ends = {
        end: {
            **dict(zip(problem.axes, pose.place, strict=True)),
            rotation: list(pose.quaternion) if rotation == "R" else _heading(pose),
        }
        for end, pose in (("start", problem.start), ("goal", problem.goal))
    }
    places = dict.fromkeys(problem.axes, NEAR * edge)
    if problem.space or not problem.control:
        turn = 2 * NEARLY if problem.space else NEARLY
        return {**ends, "goal": ends["goal"] | {"tolerance": places | {rotation: turn}}}
    # 1, the threshold of OMPL.app's distance, where its window asks for nothing else
    largest = problem.threshold or 1.0
    # 0.3: weight of speeds and steering angles in that distance; places weigh 1
    rates = dict.fromkeys(_rates(problem), largest / 0.3)
    # 0.5: weight of angles in the plane, and of rotations, of which it takes half the angle
    tolerance = dict.fromkeys(problem.axes, largest) | {rotation: largest / 0.5} | rates
    region = {"tolerance": tolerance, "norm": "sum"}
    return {**ends, "goal": ends["goal"] | dict.fromkeys(rates, 0.0) | region}


def _rates(problem: ProblemFile) -> tuple[str, ...]:
    """Return what a driven machine's state has besides its place and rotation."""
    return {
        "dynamic_car": ("v", "phi"),
        "blimp": ("x_dot", "y_dot", "z_dot", "theta_dot"),
        "quadrotor": ("x_dot", "y_dot", "z_dot", "R_wx", "R_wy", "R_wz"),
    }.get(problem.control, ())


def _rotation(problem: ProblemFile) -> str:
    return "theta" if problem.axes == "xy" or problem.control == "blimp" else "R"


def _heading(pose: CfgPose) -> float:
    """Return the angle about z of what is left of a rotation where it stays level."""
    _, _, z, w = pose.quaternion
    return pose.angle if len(pose.place) == 2 else 2.0 * math.atan2(z, w)


def _metric(problem: ProblemFile, triangles: Array) -> dict[str, float]:
    """Return the weight of rotations: what they move the robot by, on average."""
    reach = float(np.linalg.norm(triangles.reshape(-1, 3)[:, : len(problem.axes)], axis=1).max())
    return {_rotation(problem): reach / 2.0}


def _planner(problem: ProblemFile) -> dict[str, Any]:
    """Return the keys of ``[planner]``.

    OMPL's planners join poses by the shortest curves of a car's state space. kinolab's planners of
    these names drive at random; ``auto`` takes such curves first.
    """
    limit = {} if problem.time_limit is None else {"time_limit": problem.time_limit}
    return {**({} if problem.space else problem.planner.keys), **limit}


def _planner_notes(problem: ProblemFile) -> Iterator[str]:
    """Yield what is to be said of the planner that a file names."""
    named = problem.planner.keys.get("name")
    if not (problem.space and named):
        yield from problem.planner.notes
        return
    yield (
        f"OMPL's {named} joins poses by the shortest curves of {problem.space}. So does "
        f"kinolab's auto, which is taken here; --planner {named} drives at random."
    )


def _fit(name: str, triangles: Array, count: int, reach: float) -> str:
    """Say how well so many solids enclose triangles, of which they stand out so far."""
    # 0.02 of a robot's size: what stands out of it less is not told apart
    exact = 0.02 * float(np.linalg.norm(np.ptp(triangles.reshape(-1, 3), axis=0)))
    far = f"less than {exact:.1g}" if reach < exact else f"up to about {reach:.2g}"
    solids = "1 solid, which reaches" if count == 1 else f"{count} solids, which reach"
    return f"{name}: its {len(triangles)} triangles are enclosed in {solids} {far} m beyond them."


def _left_out(problem: ProblemFile) -> Iterator[str]:
    """Yield what a machine does not have of its start and goal."""
    if problem.control != "blimp":
        return
    for end, pose in (("start", problem.start), ("goal", problem.goal)):
        x, y, _, _ = pose.quaternion
        if math.hypot(x, y) > 1e-9:
            yield f"The blimp stays level: of the {end}'s rotation it has the heading alone."
