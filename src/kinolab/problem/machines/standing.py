"""One problem among obstacles that move, and without them; one machine of several.

What differs is the machine. All else that a problem says of its states goes along by their names.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from kinolab.dynamics import Model
from kinolab.numerics.arrays import Array
from kinolab.problem.goal import DirectionTarget, Goal, KeepOutCone, PointTarget
from kinolab.problem.task import PlanningTask

if TYPE_CHECKING:
    from kinolab.dynamics.language.mechanism import Mechanism
    from kinolab.dynamics.language.shapes import Shape

OfBody = TypeVar("OfBody", DirectionTarget, KeepOutCone, PointTarget)


@lru_cache(maxsize=8)
def standing(problem: PlanningTask) -> PlanningTask | None:
    """Return the problem of a machine alone with what stands still; None where nothing moves."""
    return None if problem.alone is None else with_machine(problem, *problem.alone)


@lru_cache(maxsize=16)
def part(problem: PlanningTask, name: str) -> PlanningTask:
    """Return the problem of one of several machines, without the others.

    Args:
        problem: Of machines side by side.
    """
    model = problem.model
    made = Model.described_by(json.dumps([model.key, "part", name]), partial(_part, model, name))
    return with_machine(problem, made, made)


def among(
    problem: PlanningTask, paths: Mapping[str, tuple[tuple[Shape, ...], Array]], beside: float
) -> PlanningTask:
    """Return the problem in a world in which, besides, solids move along straight lines.

    Other lines need no other code, as long as these have not many more corners.

    Args:
        problem: What to change.
        paths: By name, the solids, and the corners of their path, shape (n, 7): rows of a time in
            [s], x, y, z in [m], roll, pitch and yaw in [rad].
        beside: Distance in [m] that is kept from all obstacles besides the world's clearance.
    """
    from kinolab.dynamics.movers import fastest_between, polyline_values  # late: uses SymPy

    model = problem.model
    longest = max(len(corners) for _, corners in paths.values())
    # corners for which code is made at least: shorter paths repeat their last one
    count = 2 ** math.ceil(math.log2(max(longest, 16)))
    told = [[name, repr(shapes)] for name, (shapes, _) in paths.items()]
    content = json.dumps([model.key, "among", told, count])
    solids = {name: shapes for name, (shapes, _) in paths.items()}
    made = Model.described_by(content, partial(_among, model, solids, count))
    values: dict[str, float] = {}
    for k, (_, corners) in enumerate(paths.values()):
        values |= polyline_values(f"mover{k}", count, corners)
    moving = made.with_values(values)
    moved = with_machine(problem, moving, moving)
    fastest = max(fastest_between(c[:, 0], c[:, 1:]) for _, c in paths.values())
    moved.weights[moved.model.clocks] = fastest
    world = replace(problem.world, clearance=problem.world.clearance + beside)
    return replace(moved, world=world, alone=(model, model))


def _among(model: Model, solids: Mapping[str, tuple[Shape, ...]], count: int) -> Mechanism:
    from kinolab.dynamics.movers import Mover, parametric_polyline
    from kinolab.dynamics.movers import among as with_movers

    movers = [
        Mover(name, shapes, parametric_polyline(f"mover{k}", count))
        for k, (name, shapes) in enumerate(solids.items())
    ]
    return with_movers(model.system, movers, 1.0)


def _part(model: Model, name: str) -> Mechanism:
    from kinolab.dynamics.together import part_of

    return part_of(model.system, name)


def with_machine(problem: PlanningTask, whole: Model, model: Model) -> PlanningTask:
    """Return the same problem of another machine, by the names of states and bodies.

    What it does not have is asked no more; states that are new begin at 0, within its own limits.

    Args:
        problem: What to change.
        whole: The machine with its full input limits.
    """
    states, rates = problem.model.state_names, problem.model.rate_names
    place = [states.index(name) if name in states else -1 for name in model.state_names]
    new = np.array(place) < 0
    compared = np.zeros(model.nx)
    compared[model.clocks] = 1.0 / model.state_scales[model.clocks]

    def own(values: Any, others: Any) -> Any:
        found = values[place]
        found[new] = others
        return found

    return replace(
        problem,
        machine=whole.machine,
        model=model,
        whole=whole,
        alone=None,
        start=own(problem.start, 0.0),
        goal=_goal(problem, problem.goal, model),
        via=tuple(_goal(problem, one, model) for one in problem.via),
        bounds=own(problem.bounds, model.state_bounds[new]),
        rate_bounds=np.array(
            [
                problem.rate_bounds[rates.index(name)] if name in rates else (-np.inf, np.inf)
                for name in model.rate_names
            ]
        ).reshape(-1, 2),
        scales=own(problem.scales, model.state_scales[new]),
        weights=own(problem.weights, compared[new]),
        circular=own(problem.circular, False),
        keep_outs=_placed(problem, problem.keep_outs, model),
    )


def _goal(problem: PlanningTask, goal: Goal, model: Model) -> Goal:
    """Return what is left of a goal for another machine."""
    states, whole = problem.model.state_names, problem.start
    there = [(k, states.index(n)) for k, n in enumerate(model.state_names) if n in states]
    own, before = map(list, zip(*there, strict=True))
    spheres = {part.name: part for part in model.space.spheres}

    def holds(told: Callable[[Array], bool], x: Array) -> bool:
        known = whole.copy()
        known[before] = x[own]
        return told(known)

    def changed(one: Goal) -> Goal:
        kept = [k for k, i in enumerate(one.indices) if states[i] in model.state_names]
        return replace(
            one,
            indices=tuple(model.state_names.index(states[one.indices[k]]) for k in kept),
            targets=one.targets[kept],
            tolerances=one.tolerances[kept],
            circular=one.circular[kept],
            points=_placed(problem, one.points, model),
            directions=_placed(problem, one.directions, model),
            formulas=_placed(problem, one.formulas, model),
            parts=tuple(
                replace(target, part=spheres[target.part.name])
                for target in one.parts
                if target.part.name in spheres
            ),
            predicate=one.predicate and partial(holds, one.predicate),
        )

    return goal.changed(changed)


def _placed(problem: PlanningTask, targets: tuple[OfBody, ...], model: Model) -> tuple[OfBody, ...]:
    """Return those targets of bodies that another machine has, too."""
    names = [body.name for body in model.machine.bodies]
    called = ((one, problem.bodies[one.body].name) for one in targets)
    return tuple(replace(one, body=names.index(name)) for one, name in called if name in names)
