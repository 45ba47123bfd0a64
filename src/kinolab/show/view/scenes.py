"""Page content of a plan, or of a scenario before planning."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics import Model
from kinolab.dynamics.units import control_units, state_units
from kinolab.errors import EndpointError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.unwrapping import unwrapped
from kinolab.runs import check_to_json, goal_distance_by_unit, margin_to_json
from kinolab.search.graph import SearchGraph
from kinolab.show.film.staging.motion_script import picture
from kinolab.show.page import Content, Series
from kinolab.show.view.driving import driving_of
from kinolab.show.view.keyframes import key_poses
from kinolab.solve import PlanResult
from kinolab.trajectory import Trajectory


def plotted(model: Model, trajectory: Trajectory) -> list[Series]:
    """Return the plotted series of a plan: its states, then its inputs and references."""
    found = [Series("States", trajectory.state_names, state_units(model), trajectory.x)]
    if len(trajectory.u):
        found.append(_held("Inputs", model.plant, trajectory.u))
        if trajectory.reference_names:
            found.append(_held("References", model, trajectory.references))
    return found


def _held(title: str, model: Model, values: NDArray[np.float64]) -> Series:
    return Series(title, model.control_names, control_units(model), values, held=True)


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
        problem: The machine in its world.
        trajectory: The plan's; without one the machine is shown at its start.
        facts: About the plan, by the keys of a report.
        graph: Its search graph.
        drive: Whether the page can simulate the machine.
    """
    shown = _standing(problem) if trajectory is None else unwrapped(problem, trajectory)
    x, model = shown.x, problem.model
    scene = picture(problem, model.frames(x), model.cables(x))
    return Content(
        title=problem.scenario.title,
        name=str(facts.get("scenario", problem.name)),  # a run's file is always scenario.toml
        machine=problem.machine.name,
        picture=scene if trajectory is not None else replace(scene, path=None, start=None),
        keys=key_poses(problem, shown),
        knots=shown.t,
        series=plotted(model, shown),
        constraints=[constraint.name for constraint in problem.machine.constraints],
        facts=facts,
        tree=None if graph is None else branches(problem, graph),
        speed=problem.scenario.render.speed,
        driving=driving_of(problem, shown) if drive and not problem.machine.modes else None,
    )


def branches(problem: PlanningTask, graph: SearchGraph) -> Array:
    """Return the search graph's edges as segments of the first body, shape (edges, 2, 3)."""
    places = problem.model.frames(graph.x)[:, 0, 3::4]
    return np.asarray(places[graph.edges])


def facts_of(problem: PlanningTask, plan: PlanResult) -> dict[str, Any]:
    """Return the facts about a plan, by the keys of a report."""
    checks = plan.certificate.checks if plan.certificate else ()
    return {
        "status": plan.status,
        "message": plan.message,
        "planner": plan.planner,
        "seed": plan.seed,
        "iterations": plan.iterations,
        "cost": plan.cost,
        "duration": plan.cost,
        "goal_distance": plan.goal_distance,
        "goal_distance_by_unit": goal_distance_by_unit(problem, plan),
        "margin": margin_to_json(plan.certificate),
        "verification": [check_to_json(check) for check in checks],
    }


def readiness(problem: PlanningTask) -> dict[str, Any]:
    """Return whether start and goal of a problem are valid, and why not."""
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
