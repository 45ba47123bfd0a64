"""Page content of a plan, or of a scenario before planning."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from kinolab.errors import EndpointError, InputError
from kinolab.interchange.motion_tables import Block, blocks
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.goal import angle_between
from kinolab.problem.own_motion import other_machine
from kinolab.problem.unwrapping import unwrapped
from kinolab.runs import Run, facts_of_plan
from kinolab.search.graph import SearchGraph
from kinolab.show.scene.content import Content, Series
from kinolab.show.scene.driving import driving_of
from kinolab.show.scene.keyframes import key_poses
from kinolab.show.scene.pose_sliders import posing_of, room_of
from kinolab.show.scene.problem_picture import path_body, picture
from kinolab.simulation.reference import DivergedError, costs_along
from kinolab.solve import PlanResult
from kinolab.trajectory import Trajectory

Shown: TypeAlias = PlanResult | Trajectory | Run | None

UNPLANNED = "A motion by itself: kinolab.verify says whether it solves the problem."
UNLIMITED = (-math.inf, math.inf, "")


def told(problem: PlanningTask, trajectory: Trajectory) -> list[Series]:
    """Return the plotted series of a plan, what the task is about first, with all limits."""
    model, ruled = problem.model, set(problem.scenario.bounds)
    states, *held = blocks(problem, trajectory)
    rates = set(np.asarray(model.speeds).tolist())
    wanted = [states.names[i] for i in sorted(problem.goal.indices) if i not in rates]
    angles = _angles(problem, trajectory)
    wanted += [name for i, name in enumerate(states.names) if i not in rates and name not in wanted]
    # 3 states that are plotted at first: those that the goal names, before others
    first = () if angles else tuple(map(states.names.index, wanted[:3])) or None
    found = [_series(states, problem.bounds, ruled | set(problem.scenario.world.bounds))]
    for part in held if len(trajectory.u) else ():
        source = model.plant if part.name == "u" else model
        found.append(replace(_series(part, source.control_bounds, ruled), held=True))
    return [*angles, *_cost(problem, trajectory), replace(found[0], first=first), *found[1:]]


def _cost(problem: PlanningTask, trajectory: Trajectory) -> list[Series]:
    """Return what the motion has cost so far by [objective], if that is there."""
    if problem.scenario.objective is None or not len(trajectory.u):
        return []
    try:
        values = costs_along(problem, trajectory.t, trajectory.inputs)[:, None]
    except DivergedError:
        return []
    return [Series("Cost", ("cost so far",), ("",), values, limits=(UNLIMITED,), first=(0,))]


def _series(part: Block, bounds: Array, ruled: set[str]) -> Series:
    """Return quantities with their limits (n, 2), and whether these are the scenario's."""
    whose = ("set by the machine", "set by the scenario")
    pairs = zip(part.names, bounds.tolist(), strict=True)
    limits = tuple((low, high, whose[name in ruled]) for name, (low, high) in pairs)
    return Series(f"{part.kind.capitalize()}s", part.names, part.units, part.values, limits=limits)


def _angles(problem: PlanningTask, trajectory: Trajectory) -> list[Series]:
    """Return the angles between axes and where they shall point, or must not."""
    poses = problem.model.frames(trajectory.x)
    names, columns, limits = [], [], []
    for target in problem.goal.directions:
        names.append(f"angle to target ({problem.bodies[target.body].name})")
        columns.append(angle_between(target.in_world(poses), np.asarray(target.target)))
        limits.append((-math.inf, target.tolerance, "set by the goal"))
    for cone in problem.keep_outs:
        names.append(f"angle to keep-out direction ({problem.bodies[cone.body].name})")
        columns.append(cone.angle(poses))
        limits.append((cone.half_angle, math.inf, "set by the scenario"))
    if not names:
        return []
    values = np.degrees(np.stack(columns, axis=1))
    degrees = tuple((math.degrees(a), math.degrees(b), whose) for a, b, whose in limits)
    units, first = ("°",) * len(names), tuple(range(len(names)))
    return [Series("Angles", tuple(names), units, values, limits=degrees, first=first)]


def content_of(
    problem: PlanningTask,
    trajectory: Trajectory | None,
    facts: Mapping[str, Any],
    graph: SearchGraph | None = None,
    *,
    drive: bool = True,
) -> Content:
    """Return the content of a page.

    Args:
        trajectory: The plan's; without one the machine is shown at its start.
        facts: About the plan, by the keys of a report.
        drive: Whether the page can simulate the machine.
    """
    shown = _standing(problem) if trajectory is None else unwrapped(problem, trajectory)
    scene = picture(problem, shown.x)
    posing = posing_of(problem) if drive and trajectory is None else None
    if posing and not problem.asks:
        scene = replace(scene, follow=True, bounds=room_of(problem, posing))
    return Content(
        title=problem.scenario.title,
        name=str(facts.get("scenario", problem.name)),  # a run's file is always scenario.toml
        machine=problem.machine.name,
        picture=scene if trajectory is not None else replace(scene, path=None, start=None),
        keys=key_poses(problem, shown),
        joints=problem.machine.joints.names,
        leading=path_body(problem, problem.model.frames(shown.x)),
        knots=shown.t,
        series=told(problem, shown),
        constraints=[constraint.name for constraint in problem.machine.constraints],
        facts=facts,
        tree=None if graph is None else branches(problem, graph),
        speed=problem.scenario.render.speed,
        driving=driving_of(problem, shown) if drive else None,
        posing=posing,
    )


def content_of_plan(problem: PlanningTask, plan: Shown) -> Content:
    """Return what is shown of a plan, or of a problem before planning.

    Raises:
        InputError: If the trajectory is another machine's.
    """
    if plan is None:
        return content_of(problem, None, readiness(problem))
    motion = plan if isinstance(plan, Trajectory) else plan.trajectory
    if motion is not None and (mistakes := list(other_machine(problem, motion))):
        raise InputError(mistakes)
    if isinstance(plan, Run):
        return content_of(problem, motion, plan.report, plan.graph)
    if isinstance(plan, Trajectory):
        facts = {"status": "simulated", "duration": plan.duration, "message": UNPLANNED}
        return content_of(problem, plan, facts)
    return content_of(problem, plan.trajectory, facts_of_plan(problem, plan), plan.graph)


def branches(problem: PlanningTask, graph: SearchGraph) -> Array:
    """Return the search graph's edges as segments of the leading body, shape (edges, 2, 3)."""
    places = problem.model.frames(graph.x)[:, problem.leading, 3::4]
    return np.asarray(places[graph.edges])


def readiness(problem: PlanningTask) -> dict[str, Any]:
    """Return whether start and goal of a problem are valid, and why not.

    A problem without a goal is a machine by itself.
    """
    if not problem.asks:
        return {"status": "machine", "message": "The machine by itself. Move it by its sliders."}
    try:
        problem.check_endpoints()
    except EndpointError as error:
        return {"status": "impossible", "message": str(error)}
    return {"status": "ready", "message": "Start and goal are possible."}


def _standing(problem: PlanningTask) -> Trajectory:
    """Return the machine at its start, as a trajectory of a single knot."""
    names = problem.model.plant.control_names
    return Trajectory(
        np.zeros(1),
        problem.start[None],
        np.zeros((0, len(names))),
        problem.model.state_names,
        names,
    )
